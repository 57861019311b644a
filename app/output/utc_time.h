#pragma once

#include <chrono>
#include <string>

namespace pathfit::app {

/// 2026-11-21T03:47:12Z
std::string UtcIso(std::chrono::system_clock::time_point time);
std::string UtcIsoNow();
/// 2026-11-21_034712, for folder names.
std::string UtcFolderName(std::chrono::system_clock::time_point time);
/// "3:49" or "1:02:05"; "?" when not finite. Negative durations count as zero.
std::string ClockText(double seconds);
/// For people: "12.3 s", "4 min 05 s", "2 h 07 min".
std::string DurationText(double seconds);

}  // namespace pathfit::app
