#include "app/command/child_process.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string_view>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "renderer/core/error.h"

namespace pathfit::app {

namespace fs = std::filesystem;
using renderer::IoError;

std::optional<int> RunChild(const ChildProcess& process, const StopSignals& signals) {
  std::vector<std::string> copy = process.words;
  std::vector<char*> argv;
  for (std::string& word : copy) argv.push_back(word.data());
  argv.push_back(nullptr);
  const std::string program = process.program.string();
  const std::string output = process.output.empty() ? "/dev/null" : process.output.string();
  std::signal(SIGCHLD, SIG_DFL);  // if it were ignored, nobody could wait for the child
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) throw IoError("no process can be started: too many, or too little memory");
  if (child == 0) {
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(static_cast<int>(ExitStatus::kStopped));
    const int file = open(output.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (file >= 0) {
      dup2(file, STDOUT_FILENO);
      if (process.errors_too) dup2(file, STDERR_FILENO);
    }
    execv(program.c_str(), argv.data());
    _exit(static_cast<int>(ExitStatus::kInternalError));
  }
  constexpr auto kPause = std::chrono::milliseconds(20);
  bool told = false;
  int status = 0;
  while (true) {
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child) break;
    if (ended < 0 && errno != EINTR) {
      throw IoError("the process of " + process.words.front() +
                    " is lost: " + std::generic_category().message(errno));
    }
    if (!told && signals.Received()) {
      kill(child, *signals.Received() == ExitStatus::kInterrupted ? SIGINT : SIGTERM);
      told = true;
    }
    std::this_thread::sleep_for(kPause);
  }
  if (!WIFEXITED(status)) return std::nullopt;
  return WEXITSTATUS(status);
}

std::string EndOf(const std::string& text) {
  constexpr std::size_t kShown = 600;
  return text.size() <= kShown ? text : "..." + text.substr(text.size() - kShown);
}

std::optional<fs::path> FindProgram(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path == nullptr ? "" : path;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    const fs::path file = fs::path(rest.substr(0, end)) / name;
    rest.remove_prefix(std::min(end + 1, rest.size()));
    std::error_code ignored;
    if (fs::is_regular_file(file, ignored) && access(file.c_str(), X_OK) == 0) return file;
  }
  return std::nullopt;
}

}  // namespace pathfit::app
