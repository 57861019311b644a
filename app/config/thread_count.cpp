#include "app/config/thread_count.h"

#include <charconv>
#include <stdexcept>
#include <system_error>

#include "renderer/core/parallel.h"

namespace pathfit::app {

std::optional<int> ParseThreadCount(const std::string& text) {
  int value = 0;
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (error != std::errc() || end != last || value < 1) return std::nullopt;
  return value;
}

int RequireThreadCount(const std::string& name, const std::string& text) {
  if (const std::optional<int> count = ParseThreadCount(text)) return *count;
  throw std::invalid_argument(name + ": '" + text + "' is not a whole number of at least 1");
}

int NumThreads(std::optional<int> asked, int in_config, std::optional<int> in_environment) {
  if (asked) return *asked;
  if (in_config > 0) return in_config;
  return in_environment ? *in_environment : renderer::DefaultNumThreads();
}

}  // namespace pathfit::app
