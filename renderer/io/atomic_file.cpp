#include "renderer/io/atomic_file.h"

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <system_error>

#include <unistd.h>

#include "renderer/core/error.h"
#include "renderer/io/disk_full_error.h"

namespace pathfit::renderer {
namespace {

constexpr std::uintmax_t kLittleRoom = 65536;  // bytes

/// Distinct for every call of every process that writes into the folder.
std::filesystem::path TemporaryPathFor(const std::filesystem::path& path) {
  static std::atomic<std::uint64_t> counter = 0;
  const std::string unique = std::to_string(::getpid()) + "-" + std::to_string(counter++);
  std::filesystem::path temporary = path;
  temporary.replace_filename("." + path.stem().string() + ".tmp-" + unique +
                             path.extension().string());
  return temporary;
}

}  // namespace

void CheckRegularFile(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_type type = std::filesystem::status(path, error).type();
  if (type == std::filesystem::file_type::not_found) {
    throw IoError(path.string() + ": no such file");
  }
  if (type != std::filesystem::file_type::regular) {
    throw IoError(path.string() + ": not a regular file");
  }
}

void CreateFolders(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error == std::errc::no_space_on_device) {
    throw DiskFullError(path.string() + ": cannot be created: the disk is full");
  }
  if (error) throw IoError(path.string() + ": cannot be created: " + error.message());
}

std::string ReadWholeFile(const std::filesystem::path& path) {
  CheckRegularFile(path);
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  std::ifstream stream(path, std::ios::binary);
  if (error || !stream) throw IoError(path.string() + ": cannot be opened for reading");
  std::string bytes(static_cast<std::size_t>(size), '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (static_cast<std::size_t>(stream.gcount()) != bytes.size()) {
    throw IoError(path.string() + ": reading stopped after " + std::to_string(stream.gcount()) +
                  " of " + std::to_string(bytes.size()) + " bytes");
  }
  return bytes;
}

void WriteThroughTemporary(const std::filesystem::path& path,
                           const std::function<void(const std::filesystem::path&)>& write) {
  if (!path.has_filename()) throw IoError(path.string() + ": is not a file name");
  std::error_code error;
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  if (!std::filesystem::is_directory(folder, error)) {
    throw IoError(path.string() + ": its folder does not exist");
  }
  const std::filesystem::path temporary = TemporaryPathFor(path);
  try {
    write(temporary);
    std::filesystem::rename(temporary, path, error);
    if (error) throw IoError(path.string() + ": cannot be written: " + error.message());
  } catch (...) {
    // Whatever wrote, it cannot say why: the rest of a full disk is less than what it asked for.
    const std::filesystem::space_info space = std::filesystem::space(folder, error);
    const bool full = !error && space.capacity > 0 && space.available < kLittleRoom;
    std::filesystem::remove(temporary, error);
    if (full) throw DiskFullError(path.string() + ": cannot be written: the disk is full");
    throw;
  }
}

void WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes) {
  WriteThroughTemporary(path, [&](const std::filesystem::path& temporary) {
    errno = 0;
    std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (stream) return;
    const std::string reason = errno == 0 ? "" : ": " + std::generic_category().message(errno);
    throw IoError(path.string() + ": cannot be written" + reason);
  });
}

}  // namespace pathfit::renderer
