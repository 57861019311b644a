#pragma once

#include <string>

#include "app/config/schema.h"
#include "app/config/yaml_node.h"

namespace pathfit::app {

// Keys of `map` that depend on the value of another key there (`when_key`), given or by default.

/// Value of the key that decides about `child`, which must have one.
std::string DiscriminatorOf(const SchemaNode& map, const SchemaNode& child, const YamlNode& node);

/// Whether that value is one of those possible; true for keys that depend on nothing.
bool IsDiscriminatorKnown(const SchemaNode& map, const SchemaNode& child, const YamlNode& node);

/// Whether the key belongs to this map. Unknown or missing values rule nothing out.
bool BelongsTo(const SchemaNode& map, const SchemaNode& child, const YamlNode& node);

/// Whether the key must be given, alone or as one of its group.
bool IsRequired(const SchemaNode& map, const SchemaNode& child, const YamlNode& node);
bool IsGroupRequired(const SchemaNode& map, const SchemaNode& child, const YamlNode& node);

}  // namespace pathfit::app
