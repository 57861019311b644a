#include "app/output/config_json.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "app/config/nearest_name.h"
#include "app/config/scalar.h"

namespace pathfit::app {
namespace {

using Type = SchemaNode::Type;
using Presence = SchemaNode::Presence;

Json RangeOf(const SchemaNode& node, const char* type) {
  Json json = {{"type", type}};
  if (!node.has_range) return json;
  // Infinities are no JSON; they bound nothing.
  const auto bound = [&](double value) -> Json {
    const bool whole = node.type == Type::kInteger && std::abs(value) < 1e15;
    return whole ? Json(static_cast<std::int64_t>(value)) : Json(value);
  };
  if (std::isfinite(node.range.lower)) {
    json[node.range.lower_open ? "exclusiveMinimum" : "minimum"] = bound(node.range.lower);
  }
  if (std::isfinite(node.range.upper)) {
    json[node.range.upper_open ? "exclusiveMaximum" : "maximum"] = bound(node.range.upper);
  }
  return json;
}

Json WordsJson(const std::vector<std::string>& words) {
  Json list = Json::array();
  for (const std::string& word : words) list.push_back(PlainJson(DefaultValue(word)));
  return {{"enum", std::move(list)}};
}

/// "KEY is one of VALUES", also where the key is absent and its default is one of them.
Json IsOneOf(const SchemaNode& map,
             const std::string& key,
             const std::vector<std::string>& values) {
  Json json = {{"properties", {{key, WordsJson(values)}}}};
  if (!Contains(values, map.Child(key)->default_yaml)) json["required"] = Json::array({key});
  return json;
}

Json Required(const std::string& key) { return {{"required", Json::array({key})}}; }

Json SchemaOf(const SchemaNode& node);

/// What one key says about the others of its map.
void AddConditions(const SchemaNode& map, const SchemaNode& child, Json& conditions) {
  if (!child.when_key.empty()) {
    conditions.push_back(
        {{"if", Required(child.key)}, {"then", IsOneOf(map, child.when_key, child.when_values)}});
  }
  const std::vector<std::string>& values =
      child.required_values.empty() ? child.when_values : child.required_values;
  if (child.presence == Presence::kRequired && !values.empty()) {
    conditions.push_back(
        {{"if", IsOneOf(map, child.when_key, values)}, {"then", Required(child.key)}});
  }
}

/// At most, or exactly, one key of each group of alternatives.
void AddGroups(const SchemaNode& map, Json& conditions) {
  std::set<std::string> done;
  for (const SchemaNode& child : map.children) {
    if (child.one_of.empty() || !done.insert(child.one_of).second) continue;
    Json any = Json::array();
    Json pairs = Json::array();
    std::vector<std::string> members;
    std::vector<std::string> when_values;  // for which any of the group belongs to the map
    bool always = false;
    for (const SchemaNode& other : map.children) {
      if (other.one_of != child.one_of) continue;
      for (const std::string& before : members) {
        pairs.push_back({{"required", Json::array({before, other.key})}});
      }
      members.push_back(other.key);
      always = always || other.when_key.empty();
      for (const std::string& value : other.when_values) {
        if (!Contains(when_values, value)) when_values.push_back(value);
      }
      any.push_back(Required(other.key));
    }
    if (!pairs.empty()) conditions.push_back({{"not", {{"anyOf", std::move(pairs)}}}});
    const Json one = {{"anyOf", std::move(any)}};
    if (!child.one_of_values.empty()) {
      conditions.push_back(
          {{"if", IsOneOf(map, child.when_key, child.one_of_values)}, {"then", one}});
    } else if (!always) {
      conditions.push_back({{"if", IsOneOf(map, child.when_key, when_values)}, {"then", one}});
    } else {
      conditions.push_back(one);
    }
  }
}

Json MapSchema(const SchemaNode& map) {
  Json json = {{"type", "object"}, {"properties", Json::object()}, {"additionalProperties", false}};
  Json required = Json::array();
  Json needs = Json::object();
  Json conditions = Json::array();
  for (const SchemaNode& child : map.children) {
    json["properties"][child.key] = SchemaOf(child);
    if (child.presence == Presence::kRequired && child.required_values.empty() &&
        child.when_key.empty()) {
      required.push_back(child.key);
    }
    if (!child.needs.empty()) needs[child.key] = Json::array({child.needs});
    AddConditions(map, child, conditions);
  }
  AddGroups(map, conditions);
  if (!required.empty()) json["required"] = std::move(required);
  if (!needs.empty()) json["dependentRequired"] = std::move(needs);
  if (!conditions.empty()) json["allOf"] = std::move(conditions);
  return json;
}

Json NamedMapSchema(const SchemaNode& node) {
  Json json = {{"type", "object"}, {"additionalProperties", SchemaOf(node.children.front())}};
  if (!node.free_names) json["propertyNames"] = {{"pattern", "^[A-Za-z0-9_-]+$"}};
  if (node.min_items > 0) json["minProperties"] = node.min_items;
  return json;
}

Json ListSchema(const SchemaNode& node) {
  Json json = {{"type", "array"}, {"items", SchemaOf(node.children.front())}};
  if (node.min_items > 0) json["minItems"] = node.min_items;
  if (node.max_items > 0) json["maxItems"] = node.max_items;
  if (node.distinct) json["uniqueItems"] = true;
  return json;
}

Json TypeSchema(const SchemaNode& node) {
  // What YAML takes for a number or boolean is text where text is wanted.
  const Json text = {{"type", {"string", "number", "boolean"}}, {"minLength", 1}};
  switch (node.type) {
    case Type::kBool:
      return {{"type", "boolean"}};
    case Type::kInteger:
      return RangeOf(node, "integer");
    case Type::kNumber:
      return RangeOf(node, "number");
    case Type::kName:
      return {{"type", {"string", "integer", "boolean"}}, {"pattern", "^[A-Za-z0-9_-]+$"}};
    case Type::kChoice:
      return WordsJson(node.words);
    case Type::kBytes:
      return {{"type", "string"}, {"pattern", "^[0-9.]+ *([KMGT]i?)?B$"}};
    case Type::kList:
      return ListSchema(node);
    case Type::kMap:
      return MapSchema(node);
    case Type::kNamedMap:
      return NamedMapSchema(node);
    default:
      return text;
  }
}

Json SchemaOf(const SchemaNode& node) {
  Json json;
  if (node.type == Type::kEither) {
    json["anyOf"] = Json::array();
    for (const SchemaNode& form : node.children) json["anyOf"].push_back(SchemaOf(form));
  } else if (node.type != Type::kChoice && !node.words.empty()) {
    json["anyOf"] = Json::array({TypeSchema(node), WordsJson(node.words)});
  } else {
    json = TypeSchema(node);
  }
  std::string doc = node.doc;
  if (!node.unit.empty()) doc += (doc.empty() ? "[" : " [") + node.unit + "]";
  if (!doc.empty()) json["description"] = doc;
  if (node.presence == Presence::kDefaulted && !node.default_yaml.empty()) {
    json["default"] = PlainJson(DefaultValue(node.default_yaml));
  }
  return json;
}

void AddOrigins(const YamlNode& node,
                const std::string& path,
                const ConfigSource& source,
                Json& origins) {
  if (node.IsMap() && !node.entries.empty()) {
    for (const YamlEntry& entry : node.entries) {
      AddOrigins(entry.value, JoinPath(path, entry.key), source, origins);
    }
    return;
  }
  const bool has_maps =
      std::ranges::any_of(node.items, [](const YamlNode& item) { return item.IsMap(); });
  if (has_maps) {
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      AddOrigins(node.items[i], path + "[" + std::to_string(i) + "]", source, origins);
    }
    return;
  }
  origins[path] = node.place.source == Place::Source::kDefault ? std::string("default")
                                                               : FormatPlace(source, node.place);
}

}  // namespace

Json ConfigJsonSchema(const SchemaNode& schema) {
  Json json = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
               {"title", "Configuration of pathfit"}};
  json.update(SchemaOf(schema));
  return json;
}

Json PlainJson(const YamlNode& node) {
  if (node.IsMap()) {
    Json json = Json::object();
    for (const YamlEntry& entry : node.entries) json[entry.key] = PlainJson(entry.value);
    return json;
  }
  if (node.IsList()) {
    Json json = Json::array();
    for (const YamlNode& item : node.items) json.push_back(PlainJson(item));
    return json;
  }
  if (!node.IsScalar()) return nullptr;
  if (node.quoted) return node.text;
  if (node.text == "true" || node.text == "false") return node.text == "true";
  if (const auto whole = ParseInteger(node); whole.value) return *whole.value;
  if (const auto number = ParseNumber(node, true); number.value) return ToJson(*number.value);
  return node.text;
}

Json OriginsJson(const YamlNode& root, const ConfigSource& source) {
  Json origins = Json::object();
  AddOrigins(root, "", source, origins);
  return origins;
}

}  // namespace pathfit::app
