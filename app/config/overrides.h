#pragma once

#include <vector>

#include "app/config/config_error.h"
#include "app/config/schema.h"
#include "app/config/yaml_node.h"

namespace pathfit::app {

/// Puts `path.to.key=VALUE` (and `path.to.list+=VALUE`, which appends) into the tree, in order, as
/// if the file had said so. Items of lists are named by index, `stages[2]`, or by their name,
/// `stages.light`. What cannot be placed is reported and left out; values are not checked here.
void ApplyOverrides(const SchemaNode& schema,
                    const std::vector<ConfigOverride>& overrides,
                    YamlNode& root,
                    std::vector<Problem>& problems);

}  // namespace pathfit::app
