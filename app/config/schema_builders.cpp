#include "app/config/schema_builders.h"

#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "app/config/nearest_name.h"

namespace pathfit::app {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Type = SchemaNode::Type;

// The numbers of a list, however deep.
SchemaNode& Innermost(SchemaNode& node) {
  return node.type == Type::kList ? Innermost(node.children.front()) : node;
}

}  // namespace

Trait From(double lower, double upper) {
  return [lower, upper](SchemaNode& node) {
    SchemaNode& number = Innermost(node);
    number.has_range = true;
    number.range = {lower, upper, false, false, number.range.allow_infinite};
  };
}
Trait AtLeast(double lower) { return From(lower, kInfinity); }
Trait Above(double lower) {
  return AtLeast(lower) | [](SchemaNode& node) { Innermost(node).range.lower_open = true; };
}
Trait Between(double lower, double upper) {
  return Above(lower) | [upper](SchemaNode& node) {
    Innermost(node).range.upper = upper;
    Innermost(node).range.upper_open = true;
  };
}
Trait OrInfinite() {
  return [](SchemaNode& node) { Innermost(node).range.allow_infinite = true; };
}
Trait OrOne() {
  return [](SchemaNode& node) {
    SchemaNode one = node.children.front();
    SchemaNode list = node;
    list.store = nullptr;
    list.key.clear();
    node.type = Type::kEither;
    node.children = {std::move(one), std::move(list)};
    if (!node.default_yaml.empty()) {  // all alike: one number is enough
      Default(node.default_yaml.substr(1, node.default_yaml.find(',') - 1))(node);
    }
  };
}

const SchemaNode* SchemaNode::Child(const std::string& name) const {
  for (const SchemaNode& child : children) {
    if (child.key == name) return &child;
  }
  return nullptr;
}

const std::string* SchemaNode::AdviceFor(const std::string& name) const {
  for (const Unsupported& known : unsupported) {
    if (known.name == name) return &known.advice;
  }
  return nullptr;
}

namespace binding {

SchemaNode Make(Type type, std::string key) {
  SchemaNode node;
  node.type = type;
  node.key = std::move(key);
  return node;
}

std::string WriteNumber(double value) {
  return std::isinf(value) ? (value > 0.0 ? ".inf" : "-.inf") : fmt::format("{}", value);
}

}  // namespace binding

SchemaNode Map(std::string key, std::vector<SchemaNode> children) {
  SchemaNode node = binding::Make(Type::kMap, std::move(key));
  node.children = std::move(children);
  return node;
}
SchemaNode ListNode(std::string key, SchemaNode item) {
  SchemaNode node = binding::Make(Type::kList, std::move(key));
  node.children.push_back(std::move(item));
  return node;
}
SchemaNode TextNode(std::string key) { return binding::Make(Type::kText, std::move(key)); }
SchemaNode Either(std::string key, std::vector<SchemaNode> forms) {
  SchemaNode node = binding::Make(Type::kEither, std::move(key));
  node.children = std::move(forms);
  return node;
}
SchemaNode ByCheck(SchemaNode node) {
  node.store = [](const YamlNode&, void*) {};
  return node;
}
SchemaNode Word(std::string word) {
  return ByCheck(binding::Make(Type::kChoice, "") | Words({std::move(word)}));
}
SchemaNode Version(std::string key, int version) {
  return ByCheck(binding::Make(Type::kInteger, std::move(key))) | From(version, version) |
         Required();
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
      if (schema.check) schema.check(own, {node, path, problems});
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

namespace {

void CheckReferences(const SchemaNode& map, const SchemaNode& root) {
  for (const SchemaNode& child : map.children) {
    const auto require = [&](bool is_right, const std::string& what) {
      if (!is_right) throw std::logic_error("schema: '" + child.key + "' " + what);
    };
    require(child.needs.empty() || map.Child(child.needs) != nullptr,
            "needs '" + child.needs + "', which its map does not have");
    const SchemaNode* const choice = map.Child(child.when_key);
    require(child.when_key.empty() || choice != nullptr,
            "depends on '" + child.when_key + "', which its map does not have");
    for (const auto* values : {&child.when_values, &child.required_values, &child.one_of_values}) {
      for (const std::string& value : *values) {
        require(choice != nullptr && Contains(choice->words, value),
                "depends on '" + value + "', which is no value of '" + child.when_key + "'");
      }
    }
    if (!child.useless_key.empty()) {
      const SchemaNode* other = &root;
      std::istringstream path(child.useless_key);
      for (std::string key; other != nullptr && std::getline(path, key, '.');) {
        other = other->Child(key);
      }
      for (const std::string& value : child.useless_values) {
        require(other != nullptr && Contains(other->words, value),
                "has no use with " + child.useless_key + ": " + value +
                    ", which is no value of the config");
      }
    }
    CheckReferences(child, root);
  }
}

}  // namespace

void CheckReferences(const SchemaNode& root) { CheckReferences(root, root); }

}  // namespace pathfit::app
