#include "app/output/file_lock.h"

#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "renderer/core/error.h"

namespace pathfit::app {

FileLock::FileLock(const std::filesystem::path& path, int open_flags, int operation)
    : file_(open(path.c_str(), open_flags, 0666)) {
  if (file_ < 0) {
    throw renderer::IoError(path.string() + ": " + std::generic_category().message(errno));
  }
  int result = 0;
  do {
    result = flock(file_, operation);
  } while (result != 0 && errno == EINTR);
  // Some file systems have no locks; a process that is alone needs none.
  held_ = result == 0;
  taken_ = result != 0 && errno == EWOULDBLOCK;
}

FileLock::~FileLock() { close(file_); }

}  // namespace pathfit::app
