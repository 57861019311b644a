#pragma once

#include "app/config/schema.h"
#include "app/output/fields.h"

namespace pathfit::app {

/// The schema of configs as JSON Schema (draft 2020-12), for editors: what it refuses is refused
/// here, too; names that refer to each other are beyond it. `.inf` is a number.
Json ConfigJsonSchema(const SchemaNode& schema);

/// The values of a tree: plain scalars that read as true, false, null or a number become such.
Json PlainJson(const YamlNode& node);

/// Where each scalar and list of the tree was written, by its path: "default", "axe.yaml:12:5".
Json OriginsJson(const YamlNode& root, const ConfigSource& source);

}  // namespace pathfit::app
