#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/output/terminal.h"

namespace pathfit::app {

/// 2026-11-21T03:47:12Z
std::string UtcIso(std::chrono::system_clock::time_point time);
std::string UtcIsoNow();

enum class LogLevel { kTrace, kDebug, kInfo, kWarn, kError, kOff };

/// Messages for people: on standard error from `level` upwards, and in log files (from debug, or
/// lower when `level` is lower) with ISO-8601 UTC times. Control characters of the text are
/// replaced. Safe to use from several threads.
class Log {
 public:
  Log(Terminal& terminal, LogLevel level);
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;
  ~Log();

  /// Also writes to this file, at its end. Throws IoError when it cannot be opened.
  void AddFile(const std::filesystem::path& path);

  void Write(LogLevel level, const std::string& text);
  void Info(const std::string& text) { Write(LogLevel::kInfo, text); }
  void Warn(const std::string& text) { Write(LogLevel::kWarn, text); }
  void Error(const std::string& text) { Write(LogLevel::kError, text); }
  /// Warns of something that is not in the derivative, on standard error whatever the level.
  void WarnOfLimit(const std::string& limit);

  /// Texts of all warnings so far, each once, whatever the level.
  [[nodiscard]] std::vector<std::string> Warnings() const;

 private:
  class Loggers;
  Terminal& terminal_;
  LogLevel level_;
  std::unique_ptr<Loggers> loggers_;
};

}  // namespace pathfit::app
