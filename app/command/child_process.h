#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/command/stop_signals.h"

namespace pathfit::app {

/// A program to run, with its own process group: Ctrl-C comes through this process, once.
struct ChildProcess {
  std::filesystem::path program;
  std::vector<std::string> words;  ///< argv, its name for the program first
  std::filesystem::path output;    ///< stdout goes to the end of this file; empty: nowhere
  bool errors_too = false;         ///< stderr goes there, too; else to ours
};

/// Runs it to its end, passing on SIGINT and SIGTERM; it ends with this process. Its exit status;
/// empty if a signal ended it. Throws IoError when it cannot be started.
std::optional<int> RunChild(const ChildProcess& process, const StopSignals& signals);

/// What is shown of all that a process said: "..." and the last of it, where its reasons stand.
std::string EndOf(const std::string& text);

/// Where PATH has the program; empty if nowhere.
std::optional<std::filesystem::path> FindProgram(const std::string& name);

}  // namespace pathfit::app
