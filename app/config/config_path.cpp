#include "app/config/config_path.h"

#include <cstdlib>

namespace pathfit::app {
namespace {

Parsed<std::string> ExpandVariables(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t open = text.find("${", i);
    out += text.substr(i, open - i);
    if (open == std::string::npos) break;
    const std::size_t close = text.find('}', open);
    if (close == std::string::npos) return {{}, "'${' is never closed by '}'"};
    const std::string name = text.substr(open + 2, close - open - 2);
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing sets variables.
    const char* value = name.empty() ? nullptr : std::getenv(name.c_str());
    if (value == nullptr) return {{}, "environment variable '" + name + "' is not set"};
    out += value;
    i = close + 1;
  }
  return {out, {}};
}

}  // namespace

Parsed<std::filesystem::path> ResolvePath(const std::string& text,
                                          const std::filesystem::path& folder) {
  Parsed<std::string> expanded = ExpandVariables(text);
  if (!expanded.value) return {{}, expanded.problem};
  std::string& path = *expanded.value;
  if (path == "~" || path.rfind("~/", 0) == 0) {
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing sets variables.
    const char* home = std::getenv("HOME");
    if (home == nullptr) return {{}, "'~' cannot be replaced, HOME is not set"};
    path.replace(0, 1, home);
  }
  if (path.empty()) return {{}, "a path is needed, not empty text"};
  std::filesystem::path result = (folder / path).lexically_normal();
  if (!result.has_filename() && result.has_relative_path()) result = result.parent_path();
  if (result.string().find("${") != std::string::npos) {
    return {{}, "the folder '" + result.string() + "' holds '${' in its name"};
  }
  return {result, {}};
}

}  // namespace pathfit::app
