#include "app/config/schema_condition.h"

#include <algorithm>
#include <vector>

namespace pathfit::app {
namespace {

bool Contains(const std::vector<std::string>& list, const std::string& text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

}  // namespace

std::string DiscriminatorOf(const SchemaNode& map, const SchemaNode& child, const YamlNode& node) {
  const YamlNode* value = node.Find(child.when_key);
  return value != nullptr ? value->text : map.Child(child.when_key)->default_yaml;
}

bool IsDiscriminatorKnown(const SchemaNode& map, const SchemaNode& child, const YamlNode& node) {
  return child.when_key.empty() ||
         Contains(map.Child(child.when_key)->words, DiscriminatorOf(map, child, node));
}

bool BelongsTo(const SchemaNode& map, const SchemaNode& child, const YamlNode& node) {
  return child.when_key.empty() || !IsDiscriminatorKnown(map, child, node) ||
         Contains(child.when_values, DiscriminatorOf(map, child, node));
}

bool IsRequired(const SchemaNode& map, const SchemaNode& child, const YamlNode& node) {
  return child.presence == SchemaNode::Presence::kRequired &&
         (child.required_values.empty() ||
          Contains(child.required_values, DiscriminatorOf(map, child, node)));
}

bool IsGroupRequired(const SchemaNode& map, const SchemaNode& child, const YamlNode& node) {
  return child.one_of_values.empty() ||
         Contains(child.one_of_values, DiscriminatorOf(map, child, node));
}

}  // namespace pathfit::app
