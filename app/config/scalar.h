#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "app/config/yaml_node.h"

namespace pathfit::app {

/// What a scalar of the file means, read strictly: the value, or why it is none (what was found and
/// what to write instead).
template <class T>
struct Parsed {
  std::optional<T> value;
  std::string problem;  ///< set if there is no value
};

/// Numbers as in YAML 1.2: 1, -0.5, 1e-3, .inf (if allowed); never quoted, 012, 1,5, inf or NaN.
Parsed<double> ParseNumber(const YamlNode& node, bool allow_infinite);
Parsed<std::int64_t> ParseInteger(const YamlNode& node);
/// true or false.
Parsed<bool> ParseBool(const YamlNode& node);
/// "16 GiB", "500MB", as bytes. Powers of 1024 for KiB MiB GiB TiB, of 1000 for KB MB GB TB.
Parsed<double> ParseBytes(const YamlNode& node);
/// A path as written in a file: a leading `~/` and every `${VAR}` are replaced, what is relative is
/// taken from `folder`, and the result is absolute and normal.
Parsed<std::filesystem::path> ResolvePath(const std::string& text,
                                          const std::filesystem::path& folder);
/// "2h", "90m", "1h30m", "45s", as seconds.
std::optional<double> ParseDuration(const std::string& text);

}  // namespace pathfit::app
