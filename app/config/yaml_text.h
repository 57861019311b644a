#pragma once

#include <string>
#include <vector>

#include "app/config/yaml_node.h"

namespace pathfit::app {

/// Reading a YAML text cannot go on.
struct YamlFailure {
  Place place;
  std::string text;
};

/// The lines of a text. Throws YamlFailure for bytes that are no printable UTF-8 and for tabs used
/// as indentation, which the parser would take for something else.
std::vector<std::string> SplitTextLines(const std::string& text);

}  // namespace pathfit::app
