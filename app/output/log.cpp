#include "app/output/log.h"

#include <algorithm>
#include <mutex>

#include <fmt/chrono.h>
#include <spdlog/logger.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/basic_file_sink.h>

#include "app/output/fields.h"
#include "renderer/core/error.h"

namespace pathfit::app {
namespace {

spdlog::level::level_enum SpdlogLevel(LogLevel level) {
  // The library has one level more, `critical`, before `off`.
  return level == LogLevel::kOff ? spdlog::level::off
                                 : static_cast<spdlog::level::level_enum>(level);
}
static_assert(static_cast<int>(LogLevel::kTrace) == spdlog::level::trace &&
              static_cast<int>(LogLevel::kError) == spdlog::level::err);

std::string LevelName(spdlog::level::level_enum level) {
  if (level == spdlog::level::warn) return "warning";
  if (level == spdlog::level::err) return "error";
  const auto name = spdlog::level::to_string_view(level);
  return {name.data(), name.size()};
}

std::string_view LevelColor(spdlog::level::level_enum level) {
  if (level == spdlog::level::err) return "1;31";
  if (level == spdlog::level::warn) return "1;33";
  return level == spdlog::level::info ? "" : "2";
}

/// Sends each message as one line to the terminal, above the status line.
class TerminalSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit TerminalSink(Terminal& terminal) : terminal_(terminal) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string text(message.payload.data(), message.payload.size());
    const std::string level = LevelName(message.level);
    const bool color = terminal_.options().color;
    switch (terminal_.options().style) {
      case LineStyle::kJson: {
        const Json line = {{"time", UtcIso(message.time)}, {"level", level}, {"message", text}};
        terminal_.PrintLine(JsonText(line, -1));
        return;
      }
      case LineStyle::kStamped:
        terminal_.PrintLine(UtcIso(message.time) + " " +
                            Colored(level, LevelColor(message.level), color) + " " + text);
        return;
      case LineStyle::kHuman:
        const std::string prefix =
            message.level == spdlog::level::info
                ? ""
                : Colored(level + ":", LevelColor(message.level), color) + " ";
        terminal_.PrintLine(prefix + text);
        return;
    }
  }
  void flush_() override {}

 private:
  Terminal& terminal_;
};

}  // namespace

std::string UtcIso(std::chrono::system_clock::time_point time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
}

std::string UtcIsoNow() { return UtcIso(std::chrono::system_clock::now()); }

class Log::Loggers {
 public:
  explicit Loggers(Terminal& terminal) : logger("pathfit") {
    logger.sinks().push_back(std::make_shared<TerminalSink>(terminal));
  }
  spdlog::logger logger;
  mutable std::mutex mutex;  ///< of `warnings`
  std::vector<std::string> warnings;
};

Log::Log(Terminal& terminal, LogLevel level)
    : terminal_(terminal), level_(level), loggers_(std::make_unique<Loggers>(terminal)) {
  loggers_->logger.sinks().front()->set_level(SpdlogLevel(level));
  loggers_->logger.set_level(SpdlogLevel(std::min(level, LogLevel::kDebug)));
  loggers_->logger.flush_on(spdlog::level::debug);
}

Log::~Log() = default;

void Log::AddFile(const std::filesystem::path& path) {
  try {
    auto sink = std::make_shared<spdlog::sinks::basic_file_sink_mt>(path.string());
    sink->set_formatter(std::make_unique<spdlog::pattern_formatter>(
        "%Y-%m-%dT%H:%M:%S.%eZ %l %v", spdlog::pattern_time_type::utc));
    sink->set_level(SpdlogLevel(std::min(level_, LogLevel::kDebug)));
    loggers_->logger.sinks().push_back(std::move(sink));
  } catch (const spdlog::spdlog_ex& error) {
    throw renderer::IoError(path.string() + ": the log cannot be opened: " + error.what());
  }
}

void Log::Write(LogLevel level, const std::string& text) {
  const std::string clean = WithoutControls(text);
  if (level == LogLevel::kWarn) {
    const std::scoped_lock lock(loggers_->mutex);
    std::vector<std::string>& warnings = loggers_->warnings;
    if (std::ranges::find(warnings, clean) == warnings.end()) {
      warnings.push_back(clean);
    }
  }
  loggers_->logger.log(SpdlogLevel(level), spdlog::string_view_t(clean));
}

void Log::WarnOfLimit(const std::string& limit) {
  const std::string text = "not in the derivative: " + WithoutControls(limit);
  Warn(text);
  if (level_ > LogLevel::kWarn) terminal_.PrintLine("warning: " + text);
}

std::vector<std::string> Log::Warnings() const {
  const std::scoped_lock lock(loggers_->mutex);
  return loggers_->warnings;
}

}  // namespace pathfit::app
