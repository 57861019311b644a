#include "app/config/schema_builders.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace pathfit::app {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Type = SchemaNode::Type;

// The numbers of a list, however deep.
SchemaNode& Innermost(SchemaNode& node) {
  return node.type == Type::kList ? Innermost(node.children.front()) : node;
}

}  // namespace

SchemaNode& SchemaNode::Default(std::string yaml) {
  presence = Presence::kDefaulted;
  default_yaml = std::move(yaml);
  return *this;
}
SchemaNode& SchemaNode::Optional() {
  presence = Presence::kOptional;
  default_yaml.clear();
  return *this;
}
SchemaNode& SchemaNode::DefaultIs(std::string text) {
  default_doc = std::move(text);
  return Optional();
}
SchemaNode& SchemaNode::Required() {
  Optional();
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
  SchemaNode& number = Innermost(*this);
  number.has_range = true;
  number.range = {lower, upper, false, false, number.range.allow_infinite};
  return *this;
}
SchemaNode& SchemaNode::AtLeast(double lower) { return From(lower, kInfinity); }
SchemaNode& SchemaNode::Above(double lower) {
  From(lower, kInfinity);
  Innermost(*this).range.lower_open = true;
  return *this;
}
SchemaNode& SchemaNode::Between(double lower, double upper) {
  From(lower, upper);
  Innermost(*this).range.lower_open = true;
  Innermost(*this).range.upper_open = true;
  return *this;
}
SchemaNode& SchemaNode::OrInfinite() {
  Innermost(*this).range.allow_infinite = true;
  return *this;
}
SchemaNode& SchemaNode::Words(std::vector<std::string> list) {
  words = std::move(list);
  return *this;
}
SchemaNode& SchemaNode::OrWord(const std::string& w) { return Words({w}).Default(w); }
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
  return Optional();
}
SchemaNode& SchemaNode::OneOfFor(std::string group, std::vector<std::string> values) {
  one_of_values = std::move(values);
  return OneOf(std::move(group));
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
SchemaNode& SchemaNode::Distinct() {
  distinct = true;
  return *this;
}
SchemaNode& SchemaNode::OrOne() {
  SchemaNode one = children.front();
  SchemaNode list = *this;
  list.store = nullptr;
  list.key.clear();
  type = Type::kEither;
  children = {std::move(one), std::move(list)};
  if (!default_yaml.empty()) {  // all alike: one number is enough
    const std::string first = default_yaml.substr(1, default_yaml.find(',') - 1);
    Default(first);
  }
  return *this;
}

const SchemaNode* SchemaNode::Child(const std::string& name) const {
  for (const SchemaNode& child : children) {
    if (child.key == name) return &child;
  }
  return nullptr;
}

namespace binding {

SchemaNode Make(Type type, std::string key, std::string doc) {
  SchemaNode node;
  node.type = type;
  node.key = std::move(key);
  node.doc = std::move(doc);
  return node;
}

std::string Write(bool value) { return value ? "true" : "false"; }
std::string Write(int value) { return std::to_string(value); }
std::string Write(std::uint64_t value) { return std::to_string(value); }
std::string Write(double value) {
  return std::isinf(value) ? (value > 0.0 ? ".inf" : "-.inf") : fmt::format("{}", value);
}
std::string Write(const std::string& value) { return value; }
std::string Write(const std::filesystem::path& value) { return value.string(); }

void Read(const YamlNode& node, bool& value) { value = ParseBool(node).value.value_or(value); }
void Read(const YamlNode& node, int& value) {
  value = static_cast<int>(ParseInteger(node).value.value_or(value));
}
void Read(const YamlNode& node, std::uint64_t& value) {
  const auto parsed = ParseInteger(node);
  if (parsed.value) value = static_cast<std::uint64_t>(*parsed.value);
}
void Read(const YamlNode& node, double& value) {
  value = ParseNumber(node, true).value.value_or(value);
}
void Read(const YamlNode& node, std::string& value) { value = node.text; }
void Read(const YamlNode& node, std::filesystem::path& value) { value = node.text; }

}  // namespace binding

SchemaNode Map(std::string key, std::vector<SchemaNode> children, std::string doc) {
  SchemaNode node = binding::Make(Type::kMap, std::move(key), std::move(doc));
  node.children = std::move(children);
  return node;
}
SchemaNode ListNode(std::string key, SchemaNode item, std::string doc) {
  SchemaNode node = binding::Make(Type::kList, std::move(key), std::move(doc));
  node.children.push_back(std::move(item));
  return node;
}
SchemaNode ListOfMaps(std::string key, SchemaNode item, std::string doc) {
  return ListNode(std::move(key), std::move(item), std::move(doc));
}
SchemaNode TextNode(std::string key, std::string doc) {
  return binding::Make(Type::kText, std::move(key), std::move(doc));
}
SchemaNode Either(std::string key, std::vector<SchemaNode> forms, std::string doc) {
  SchemaNode node = binding::Make(Type::kEither, std::move(key), std::move(doc));
  node.children = std::move(forms);
  return node;
}
SchemaNode ByCheck(SchemaNode node) {
  node.store = [](const YamlNode&, void*) {};
  return node;
}
SchemaNode Word(std::string word) {
  return ByCheck(binding::Make(Type::kChoice, "", "").Words({std::move(word)}));
}
SchemaNode Version(std::string key, int version, std::string doc) {
  return ByCheck(binding::Make(Type::kInteger, std::move(key), std::move(doc)))
      .From(version, version)
      .Required();
}

void SetDefault(YamlNode& map, const std::string& key, const std::string& yaml) {
  map.entries.push_back({key, Place{}, DefaultValue(yaml)});
}

void BindValues(const SchemaNode& schema,
                YamlNode& node,
                const std::string& path,
                void* values,
                std::vector<Problem>& problems) {
  if (schema.store) {
    if (node.kind != YamlNode::Kind::kNull) schema.store(node, values);
    return;
  }
  switch (schema.type) {
    case Type::kMap: {
      if (!node.IsMap()) return;
      void* own = schema.target ? schema.target(values, "") : values;
      for (const SchemaNode& child : schema.children) {
        YamlNode* value = node.Find(child.key);
        if (value != nullptr) BindValues(child, *value, JoinPath(path, child.key), own, problems);
      }
      if (schema.check) schema.check(own, node, path, problems);
      return;
    }
    case Type::kNamedMap:
      for (YamlEntry& entry : node.entries) {
        void* item = schema.target(values, entry.key);
        BindValues(schema.children.front(), entry.value, JoinPath(path, entry.key), item, problems);
      }
      return;
    case Type::kList:
      for (std::size_t i = 0; i < node.items.size(); ++i) {
        void* item = schema.target ? schema.target(values, "") : values;
        BindValues(
            schema.children.front(), node.items[i], fmt::format("{}[{}]", path, i), item, problems);
      }
      return;
    case Type::kEither:
      for (const SchemaNode& form : schema.children) {
        if (FitsForm(form, node)) return BindValues(form, node, path, values, problems);
      }
      return;
    default:
      return;
  }
}

void CheckBindings(const SchemaNode& schema, const std::type_info& values) {
  const auto fail = [&](const char* what) {
    throw std::logic_error("schema: '" + schema.key + "' " + what);
  };
  if (schema.owner != nullptr && *schema.owner != values) fail("is bound to another struct");
  const std::type_info& own = schema.target_type != nullptr ? *schema.target_type : values;
  if (schema.check_type != nullptr && *schema.check_type != own) fail("checks another struct");
  if (schema.store) return;
  if (schema.children.empty() && schema.type != Type::kMap) fail("is read by nothing");
  for (const SchemaNode& child : schema.children) CheckBindings(child, own);
}

}  // namespace pathfit::app
