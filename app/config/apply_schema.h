#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/config/config_error.h"
#include "app/config/schema.h"
#include "app/config/yaml_node.h"

namespace pathfit::app {

/// Checks `root` and brings it into the form that readers take for granted: everything wrong is
/// reported and removed (a named item or list item that is wrong stays as null, so that its name is
/// still known), defaults are filled in with places of kind kDefault, paths are absolute.
void ApplySchema(const SchemaNode& schema,
                 const std::filesystem::path& folder,
                 YamlNode& root,
                 std::vector<Problem>& problems);

}  // namespace pathfit::app
