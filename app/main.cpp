#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "app/command/command_line.h"
#include "optim/ranks/ranks.h"

namespace pathfit::app {
namespace {

/// Ranks other than the first end as it does, which has said why.
ExitStatus RunSilently(const CommandLine& line, optim::Ranks& ranks) {
  Terminal terminal({.write = [](std::string_view) {}, .columns = [] { return 80; }});
  Log log(terminal, LogLevel::kOff);
  try {
    CommandContext context{line, terminal, log, ranks};
    return line.run(context);
  } catch (const std::exception& e) {
    ranks.ReportException();
    return StatusOfException(e);
  }
}

/// A result that did not get out is none, such as on a full disk.
ExitStatus WithOutput(ExitStatus status) {
  if (status != ExitStatus::kFinished) return status;
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
  // The reason of an earlier failure is gone: another one tells it.
  if (errno == 0 && std::fputc('\n', stdout) != EOF) std::fflush(stdout);
  const int reason = errno;
  const bool is_full = reason == ENOSPC || reason == EDQUOT;
  std::fprintf(stderr,
               "pathfit: standard output cannot be written: %s\n",
               is_full       ? "the disk is full; make room and try again"
               : reason == 0 ? "write error"
                             : std::generic_category().message(reason).c_str());
  return is_full ? ExitStatus::kStopped : ExitStatus::kInput;
}

ExitStatus Run(const std::vector<std::string>& arguments, optim::Ranks& ranks) {
  CommandLine line;
  try {
    line = ParseCommandLine(arguments, ProcessEnvironment);
    if (line.command != nullptr && !line.command->over_ranks && !ranks.IsAlone()) {
      throw UsageError(line.command->name, "runs in one process: start it without mpirun");
    }
  } catch (const UsageError& e) {
    if (ranks.IsFirst()) std::fprintf(stderr, "%s\n", e.what());
    return ExitStatus::kUsage;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "pathfit: the command line cannot be read: %s\n", e.what());
    return StatusOfException(e);
  }
  if (!ranks.IsFirst()) {
    return line.command == nullptr ? ExitStatus::kFinished : RunSilently(line, ranks);
  }
  if (line.command == nullptr) {
    std::fputs(line.help_text.c_str(), stdout);
    return ExitStatus::kFinished;
  }
  Terminal terminal(StderrOptions(line.progress, line.color));
  Log log(terminal, line.log_level);
  try {
    if (!line.log_file.empty()) log.AddFile(line.log_file);
    CommandContext context{line, terminal, log, ranks};
    return line.run(context);
  } catch (const UsageError& e) {
    terminal.PrintLine(e.what());
    return ExitStatus::kUsage;
  } catch (const ConfigError& e) {
    terminal.PrintLine(e.what());  // complete, with a line for every problem
    return ExitStatus::kConfig;
  } catch (const std::bad_alloc&) {
    log.Error("out of memory; smaller pictures, fewer samples or photos need less");
    return ExitStatus::kMemory;
  } catch (const std::exception& e) {
    if (std::ferror(stdout) != 0) return WithOutput(ExitStatus::kFinished);
    const ExitStatus status = StatusOfException(e);
    log.Error(status == ExitStatus::kInternalError
                  ? std::string("internal error, please report it with log.txt: ") + e.what()
                  : std::string(e.what()));
    return status;
  }
}

std::terminate_handler usual_terminate = nullptr;

/// Libraries start threads where no exception gets through.
[[noreturn]] void Terminate() {
  try {
    if (const std::exception_ptr reason = std::current_exception()) std::rethrow_exception(reason);
  } catch (const std::system_error& e) {
    if (e.code() == std::errc::resource_unavailable_try_again) {
      std::fputs(
          "pathfit: a thread cannot be started: the limit of memory or of processes (ulimit -v, "
          "-u) is reached; raise it, or use --threads 1\n",
          stderr);
      std::fflush(nullptr);
      std::_Exit(static_cast<int>(ExitStatus::kMemory));
    }
  } catch (...) {
  }
  usual_terminate();
  std::abort();
}

/// Some start them as they are loaded, so that main would come too late.
void SetTerminate() { usual_terminate = std::set_terminate(Terminate); }
[[gnu::section(".preinit_array"), gnu::used]] void (*const kBeforeLibraries)() = SetTerminate;

}  // namespace
}  // namespace pathfit::app

int main(int argc, char** argv) {
  using namespace pathfit::app;
  try {
    pathfit::optim::Ranks ranks(argc, argv);
    const ExitStatus status = WithOutput(Run(std::vector<std::string>(argv, argv + argc), ranks));
    const int code = ranks.End(static_cast<int>(status));
    if (status == ExitStatus::kMemory) {
      // OpenBLAS waits for ever at exit for threads that it could not start.
      std::fflush(nullptr);
      std::_Exit(code);
    }
    return code;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "pathfit: %s\n", e.what());
    return static_cast<int>(StatusOfException(e));
  }
}
