#include "app/config/schema_builders.h"

#include <limits>
#include <utility>

namespace pathfit::app {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

SchemaNode Make(SchemaNode::Type type, std::string key, std::string doc) {
  SchemaNode node;
  node.type = type;
  node.key = std::move(key);
  node.doc = std::move(doc);
  return node;
}

}  // namespace

SchemaNode& SchemaNode::Default(std::string yaml) {
  presence = Presence::kDefaulted;
  default_yaml = std::move(yaml);
  return *this;
}
SchemaNode& SchemaNode::DefaultIs(std::string text) {
  default_doc = std::move(text);
  return *this;
}
SchemaNode& SchemaNode::Required() {
  presence = Presence::kRequired;
  return *this;
}
SchemaNode& SchemaNode::RequiredFor(std::vector<std::string> values, std::string yaml) {
  presence = Presence::kRequired;
  required_values = std::move(values);
  default_yaml = std::move(yaml);
  return *this;
}
SchemaNode& SchemaNode::Always() {
  presence = Presence::kDefaulted;
  return *this;
}
SchemaNode& SchemaNode::Unit(std::string text) {
  unit = std::move(text);
  return *this;
}
SchemaNode& SchemaNode::From(double lower, double upper) {
  has_range = true;
  range = {lower, upper, false, false, false};
  return *this;
}
SchemaNode& SchemaNode::AtLeast(double lower) { return From(lower, kInfinity); }
SchemaNode& SchemaNode::Above(double lower) {
  From(lower, kInfinity);
  range.lower_open = true;
  return *this;
}
SchemaNode& SchemaNode::Between(double lower, double upper) {
  From(lower, upper);
  range.lower_open = true;
  range.upper_open = true;
  return *this;
}
SchemaNode& SchemaNode::OrInfinite() {
  range.allow_infinite = true;
  return *this;
}
SchemaNode& SchemaNode::Words(std::vector<std::string> list) {
  words = std::move(list);
  return *this;
}
SchemaNode& SchemaNode::Refuse(std::vector<Unsupported> list) {
  unsupported = std::move(list);
  return *this;
}
SchemaNode& SchemaNode::Items(int min_count, int max_count) {
  min_items = min_count;
  max_items = max_count;
  return *this;
}
SchemaNode& SchemaNode::OneOf(std::string group) {
  one_of = std::move(group);
  return *this;
}
SchemaNode& SchemaNode::OneOfFor(std::string group, std::vector<std::string> values) {
  one_of = std::move(group);
  one_of_values = std::move(values);
  return *this;
}
SchemaNode& SchemaNode::Needs(std::string sibling) {
  needs = std::move(sibling);
  return *this;
}
SchemaNode& SchemaNode::When(std::string sibling, std::vector<std::string> values) {
  when_key = std::move(sibling);
  when_values = std::move(values);
  return *this;
}
SchemaNode& SchemaNode::FreeNames() {
  free_names = true;
  return *this;
}

const SchemaNode* SchemaNode::Child(const std::string& name) const {
  for (const SchemaNode& child : children) {
    if (child.key == name) return &child;
  }
  return nullptr;
}

SchemaNode Bool(std::string key, std::string doc) {
  return Make(SchemaNode::Type::kBool, std::move(key), std::move(doc));
}
SchemaNode Integer(std::string key, std::string doc) {
  return Make(SchemaNode::Type::kInteger, std::move(key), std::move(doc));
}
SchemaNode Number(std::string key, std::string doc) {
  return Make(SchemaNode::Type::kNumber, std::move(key), std::move(doc));
}
SchemaNode Text(std::string key, std::string doc) {
  return Make(SchemaNode::Type::kText, std::move(key), std::move(doc));
}
SchemaNode Name(std::string key, std::string doc) {
  return Make(SchemaNode::Type::kName, std::move(key), std::move(doc));
}
SchemaNode Choice(std::string key, std::vector<std::string> words, std::string doc) {
  return Make(SchemaNode::Type::kChoice, std::move(key), std::move(doc)).Words(std::move(words));
}
SchemaNode Path(std::string key, std::string doc) {
  return Make(SchemaNode::Type::kPath, std::move(key), std::move(doc));
}
SchemaNode Bytes(std::string key, std::string doc) {
  return Make(SchemaNode::Type::kBytes, std::move(key), std::move(doc));
}
SchemaNode List(std::string key, const SchemaNode& item, std::string doc) {
  SchemaNode node = Make(SchemaNode::Type::kList, std::move(key), std::move(doc));
  node.children = {item};
  return node;
}
SchemaNode Map(std::string key, std::vector<SchemaNode> children, std::string doc) {
  SchemaNode node = Make(SchemaNode::Type::kMap, std::move(key), std::move(doc));
  node.children = std::move(children);
  return node;
}
SchemaNode NamedMap(std::string key, std::string name, SchemaNode item, std::string doc) {
  SchemaNode node = Make(SchemaNode::Type::kNamedMap, std::move(key), std::move(doc));
  item.key = std::move(name);
  node.children.push_back(std::move(item));
  return node;
}
SchemaNode Either(std::string key, std::vector<SchemaNode> forms, std::string doc) {
  SchemaNode node = Make(SchemaNode::Type::kEither, std::move(key), std::move(doc));
  node.children = std::move(forms);
  return node;
}

SchemaNode Vector(std::string key, std::string doc) {
  return List(std::move(key), Number("", ""), std::move(doc)).Items(3, 3);
}
SchemaNode Colour(std::string key, std::string doc) {
  return List(std::move(key), Number("", "").AtLeast(0.0), std::move(doc))
      .Items(3, 3)
      .Unit("linear Rec.709");
}
SchemaNode Size(std::string key, std::string doc) {
  constexpr double kMaxSize = 32768;
  return List(std::move(key), Integer("", "").From(1, kMaxSize), std::move(doc))
      .Items(2, 2)
      .Unit("pixels: width, height");
}
SchemaNode Rotation(std::string key, std::string doc) {
  return Map(
      std::move(key),
      {Vector("axis", "Axis of the rotation; its length does not matter.").Required(),
       Number("angle_deg", "Angle, right-handed about the axis.").Unit("degrees").Required()},
      std::move(doc));
}

}  // namespace pathfit::app
