#include "app/output/utc_time.h"

#include <algorithm>
#include <cmath>

#include <fmt/chrono.h>
#include <fmt/format.h>

namespace pathfit::app {
namespace {

std::tm UtcFields(std::chrono::system_clock::time_point time) {
  return fmt::gmtime(std::chrono::system_clock::to_time_t(time));
}

constexpr double kLongestSeconds = 1e9;

}  // namespace

std::string UtcIso(std::chrono::system_clock::time_point time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", UtcFields(time));
}

std::string UtcIsoNow() { return UtcIso(std::chrono::system_clock::now()); }

std::string UtcFolderName(std::chrono::system_clock::time_point time) {
  return fmt::format("{:%Y-%m-%d_%H%M%S}", UtcFields(time));
}

std::string ClockText(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  const long total = std::lround(std::clamp(seconds, 0.0, kLongestSeconds));
  if (total >= 3600) {
    return fmt::format("{}:{:02}:{:02}", total / 3600, total / 60 % 60, total % 60);
  }
  return fmt::format("{}:{:02}", total / 60, total % 60);
}

std::string DurationText(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  const double s = std::clamp(seconds, 0.0, kLongestSeconds);
  if (s < 99.95) return fmt::format("{:.1f} s", s);
  const long total = std::lround(s);
  if (total < 3600) return fmt::format("{} min {:02} s", total / 60, total % 60);
  return fmt::format("{} h {:02} min", total / 3600, total / 60 % 60);
}

}  // namespace pathfit::app
