#pragma once

#include <string>

#include "app/config/config_error.h"
#include "app/config/yaml_node.h"

namespace pathfit::app {

/// The tree as YAML, with a comment behind every value that says where it was written: "# default",
/// "# axe.yaml:12", "# --set #2". Reading it gives the same values.
std::string WritePlacedYaml(const YamlNode& root, const ConfigSource& source);
/// The same under a heading, for a whole configuration.
std::string WriteResolvedYaml(const YamlNode& root, const ConfigSource& source);

}  // namespace pathfit::app
