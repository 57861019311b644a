#pragma once

#include <string>
#include <vector>

#include "app/config/schema.h"

namespace pathfit::app {

// Words in which the schema is written. `key` is empty for items of lists and alternatives.
SchemaNode Bool(std::string key, std::string doc);
SchemaNode Integer(std::string key, std::string doc);
SchemaNode Number(std::string key, std::string doc);
SchemaNode Text(std::string key, std::string doc);
SchemaNode Name(std::string key, std::string doc);
SchemaNode Choice(std::string key, std::vector<std::string> words, std::string doc);
SchemaNode Path(std::string key, std::string doc);
SchemaNode Bytes(std::string key, std::string doc);
SchemaNode List(std::string key, const SchemaNode& item, std::string doc);
SchemaNode Map(std::string key, std::vector<SchemaNode> children, std::string doc);
SchemaNode NamedMap(std::string key, std::string name, SchemaNode item, std::string doc);
SchemaNode Either(std::string key, std::vector<SchemaNode> forms, std::string doc);

/// Three finite numbers.
SchemaNode Vector(std::string key, std::string doc);
/// Three numbers of at least 0, linear Rec.709.
SchemaNode Colour(std::string key, std::string doc);
/// Width and height.
SchemaNode Size(std::string key, std::string doc);
/// {axis, angle_deg}
SchemaNode Rotation(std::string key, std::string doc);

// The parts of the tree.
SchemaNode InputSchema();
SchemaNode SceneSchema();
SchemaNode GeometrySchema();
SchemaNode MaterialsSchema();
SchemaNode TexturesSchema();
SchemaNode LightsSchema();
SchemaNode SensorsSchema();
SchemaNode UnknownsSchema();
SchemaNode StagesSchema();

}  // namespace pathfit::app
