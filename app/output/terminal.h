#pragma once

#include <functional>
#include <mutex>
#include <string>
#include <string_view>

namespace pathfit::app {

enum class ProgressMode { kAuto, kBar, kPlain, kJson, kNone };
enum class ColorMode { kAuto, kAlways, kNever };
/// How a line looks: for a person at a terminal, with time and level, or as one JSON object.
enum class LineStyle { kHuman, kStamped, kJson };

struct TerminalOptions {
  ProgressMode progress = ProgressMode::kPlain;  ///< resolved, never kAuto
  LineStyle style = LineStyle::kStamped;
  bool color = false;
  bool utf8 = false;
  std::function<void(std::string_view)> write;  ///< receives complete pieces of output
  std::function<int()> columns;                 ///< present width, at least 1
};

/// Value of an environment variable, empty when it is not set.
using Environment = std::function<std::string(const std::string&)>;
std::string ProcessEnvironment(const std::string& name);

/// --color beats NO_COLOR beats CLICOLOR_FORCE beats TERM=dumb beats whether it is a terminal.
bool ResolveColor(ColorMode mode, bool is_tty, const Environment& environment);
/// A bar needs a terminal that can redraw a line; elsewhere `auto` and `bar` mean plain lines.
ProgressMode ResolveProgress(ProgressMode mode, bool is_tty, const Environment& environment);
/// Options for this process's standard error.
TerminalOptions StderrOptions(ProgressMode progress, ColorMode color);

/// Standard error shared by the log and the progress display: lines scroll above one status line.
/// Safe to use from several threads.
class Terminal {
 public:
  explicit Terminal(TerminalOptions options);
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  ~Terminal();

  [[nodiscard]] const TerminalOptions& options() const { return options_; }
  /// Prints a line (without its newline) above the status line.
  void PrintLine(std::string_view line);
  /// Replaces the status line; only in kBar mode. It must not be wider than the terminal.
  void SetStatus(std::string status);
  void ClearStatus();

 private:
  void EraseStatus();

  TerminalOptions options_;
  std::mutex mutex_;
  std::string status_;
  bool drawn_ = false;
};

/// Whether a person can be asked: standard input and error are a terminal.
bool IsAtTerminal();
/// The line that is typed in answer, without its end; empty at the end of input.
std::string Ask(const std::string& question);

/// `text` without control characters other than newline and tab, so that names cannot steer a
/// terminal.
std::string WithoutControls(std::string_view text);
/// Wraps text in an SGR escape sequence ("1;32") when `color`.
std::string Colored(std::string_view text, std::string_view sgr, bool color);

}  // namespace pathfit::app
