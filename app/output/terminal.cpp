#include "app/output/terminal.h"

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <utility>

#include <sys/ioctl.h>
#include <unistd.h>

namespace pathfit::app {
namespace {

constexpr int kDefaultColumns = 80;
constexpr std::string_view kEraseLine = "\r\x1b[K";

int StderrColumns() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return kDefaultColumns;
}

bool LocaleIsUtf8(const Environment& environment) {
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    const std::string value = environment(name);
    if (value.empty()) continue;
    return value.find("UTF-8") != std::string::npos || value.find("utf8") != std::string::npos ||
           value.find("UTF8") != std::string::npos || value.find("utf-8") != std::string::npos;
  }
  return false;
}

}  // namespace

std::string ProcessEnvironment(const std::string& name) {
  // Nothing in the program changes the environment.
  const char* value = std::getenv(name.c_str());  // NOLINT(concurrency-mt-unsafe)
  return value == nullptr ? "" : value;
}

bool ResolveColor(ColorMode mode, bool is_tty, const Environment& environment) {
  if (mode != ColorMode::kAuto) return mode == ColorMode::kAlways;
  if (!environment("NO_COLOR").empty()) return false;
  const std::string force = environment("CLICOLOR_FORCE");
  if (!force.empty() && force != "0") return true;
  return environment("TERM") != "dumb" && is_tty;
}

ProgressMode ResolveProgress(ProgressMode mode, bool is_tty, const Environment& environment) {
  if (mode != ProgressMode::kAuto && mode != ProgressMode::kBar) return mode;
  return is_tty && environment("TERM") != "dumb" ? ProgressMode::kBar : ProgressMode::kPlain;
}

TerminalOptions StderrOptions(ProgressMode progress, ColorMode color) {
  const bool is_tty = isatty(STDERR_FILENO) == 1;
  TerminalOptions options;
  options.progress = ResolveProgress(progress, is_tty, ProcessEnvironment);
  const bool stamped = !is_tty || options.progress == ProgressMode::kPlain;
  options.style = options.progress == ProgressMode::kJson ? LineStyle::kJson
                  : stamped                               ? LineStyle::kStamped
                                                          : LineStyle::kHuman;
  options.color =
      ResolveColor(color, is_tty, ProcessEnvironment) && options.style != LineStyle::kJson;
  options.utf8 = LocaleIsUtf8(ProcessEnvironment);
  options.write = [](std::string_view text) {
    std::fwrite(text.data(), 1, text.size(), stderr);
    std::fflush(stderr);
  };
  options.columns = StderrColumns;
  return options;
}

bool IsAtTerminal() { return isatty(STDIN_FILENO) == 1 && isatty(STDERR_FILENO) == 1; }

std::string Ask(const std::string& question) {
  std::fwrite(question.data(), 1, question.size(), stderr);
  std::fflush(stderr);
  std::string answer;
  std::getline(std::cin, answer);
  return answer;
}

Terminal::Terminal(TerminalOptions options) : options_(std::move(options)) {}

Terminal::~Terminal() { ClearStatus(); }

void Terminal::EraseStatus() {
  if (drawn_) options_.write(kEraseLine);
  drawn_ = false;
}

void Terminal::PrintLine(std::string_view line) {
  const std::scoped_lock lock(mutex_);
  EraseStatus();
  options_.write(std::string(line) + "\n");
  if (!status_.empty()) {
    options_.write(status_);
    drawn_ = true;
  }
}

void Terminal::SetStatus(std::string status) {
  if (options_.progress != ProgressMode::kBar) return;
  const std::scoped_lock lock(mutex_);
  status_ = std::move(status);
  options_.write(std::string(kEraseLine) + status_);
  drawn_ = true;
}

void Terminal::ClearStatus() {
  const std::scoped_lock lock(mutex_);
  EraseStatus();
  status_.clear();
}

std::string WithoutControls(std::string_view text) {
  std::string clean;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool control = (byte < 0x20 && c != '\n' && c != '\t') || byte == 0x7f;
    clean += control ? '?' : c;
  }
  return clean;
}

std::string Colored(std::string_view text, std::string_view sgr, bool color) {
  if (!color || sgr.empty()) return std::string(text);
  std::string colored = "\x1b[";
  colored.append(sgr).append("m").append(text).append("\x1b[0m");
  return colored;
}

}  // namespace pathfit::app
