#pragma once

#include <optional>
#include <string>

namespace pathfit::app {

/// Environment variable with the number of threads where the config says auto.
inline constexpr const char* kThreadsVariable = "PATHFIT_THREADS";

/// A whole number of at least 1; empty for other text.
std::optional<int> ParseThreadCount(const std::string& text);
/// The same of the value of an option or variable. Throws std::invalid_argument.
int RequireThreadCount(const std::string& name, const std::string& text);

/// What is asked for now, then the config, then the environment, then what the machine gives.
/// `in_config` is 0 for auto.
int NumThreads(std::optional<int> asked, int in_config, std::optional<int> in_environment);

}  // namespace pathfit::app
