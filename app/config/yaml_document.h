#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/config/config_error.h"
#include "app/config/yaml_node.h"

namespace pathfit::app {

/// A YAML file as a tree with places. `problems` holds what is wrong but does not hinder reading
/// on: duplicate keys, merge keys, keys that are no text, tags.
struct YamlDocument {
  ConfigSource source;
  std::string text;  ///< byte copy of the file
  YamlNode root;
  std::vector<Problem> problems;
};

/// Reads a file. Throws ConfigError if it is missing, no UTF-8 text, larger than 16 MiB, empty, no
/// valid YAML, several documents, deeper than kMaxYamlDepth or (with aliases written out) more than
/// kMaxYamlNodes values.
YamlDocument LoadYamlFile(const std::filesystem::path& path);

/// The same for text in memory; `file` is what messages call it.
YamlDocument ParseYaml(const std::string& text, const std::string& file);

/// Reads the value of an override (a scalar, or a list or map in brackets); every place in it is
/// `place`. Problems are appended (then the result is null): `path` names the key.
YamlNode ParseOverrideValue(const std::string& text,
                            const Place& place,
                            const std::string& path,
                            std::vector<Problem>& problems);

}  // namespace pathfit::app
