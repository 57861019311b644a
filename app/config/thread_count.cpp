#include "app/config/thread_count.h"

#include <charconv>
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

int NumThreads(std::optional<int> asked, int in_config, std::optional<int> in_environment) {
  if (asked) return *asked;
  if (in_config > 0) return in_config;
  return in_environment ? *in_environment : renderer::DefaultNumThreads();
}

}  // namespace pathfit::app
