#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "app/config/nearest_name.h"
#include "app/config/schema.h"
#include "app/config/yaml_document.h"

namespace pathfit::app {
namespace {

using Type = SchemaNode::Type;

// Finds or makes the node that a path leads to.
class PathWalker {
 public:
  PathWalker(std::string path, const Place& place, std::vector<Problem>& problems)
      : path_(std::move(path)), place_(place), problems_(problems) {}

  // `rest` is empty, or starts with '.' or '['. Null if there is no such place (reported).
  YamlNode* Find(const SchemaNode& schema, YamlNode& node, std::string_view rest) {
    if (rest.empty()) return &node;
    switch (schema.type) {
      case Type::kMap:
        return FindInMap(schema, node, rest);
      case Type::kNamedMap:
        return FindInNamedMap(schema, node, rest);
      case Type::kList:
        return FindInList(schema, node, rest);
      case Type::kEither:
        for (const SchemaNode& form : schema.children) {
          if (form.type == (rest[0] == '[' ? Type::kList : Type::kMap)) {
            return Find(form, node, rest);
          }
        }
        break;
      default:
        break;
    }
    return Fail("no such key; " + Consumed(rest) + " holds " + DescribeType(schema));
  }

 private:
  YamlNode* Fail(std::string text) {
    problems_.push_back({place_, path_, std::move(text)});
    return nullptr;
  }

  // The part of the path before `rest`.
  [[nodiscard]] std::string Consumed(std::string_view rest) const {
    const std::string done = path_.substr(0, path_.size() - rest.size());
    return done.empty() ? "the config" : "'" + done + "'";
  }

  // Splits ".key" off.
  static std::string TakeKey(std::string_view& rest) {
    rest.remove_prefix(1);
    std::string key(rest.substr(0, rest.find_first_of(".[")));
    rest.remove_prefix(key.size());
    return key;
  }

  bool MakeMap(YamlNode& node, std::string_view rest) {
    if (node.kind == YamlNode::Kind::kNull) {
      node.kind = YamlNode::Kind::kMap;
      node.place = place_;
    }
    if (node.IsMap()) return true;
    Fail(Consumed(rest) + " is " + DescribeNode(node) + ", not a map");
    return false;
  }

  YamlNode* FindInMap(const SchemaNode& schema, YamlNode& node, std::string_view rest) {
    if (rest[0] == '[') return Fail("no such key; " + Consumed(rest) + " is not a list");
    const std::string_view before = rest;
    const std::string key = TakeKey(rest);
    const SchemaNode* child = schema.Child(key);
    if (child == nullptr) {
      if (const std::string* advice = schema.AdviceFor(key)) {
        return Fail("key '" + key + "' is not supported" + *advice);
      }
      std::vector<std::string> keys;
      for (const SchemaNode& c : schema.children) keys.push_back(c.key);
      return Fail("no such key" + NameHint(key, keys));
    }
    if (!MakeMap(node, before)) return nullptr;
    if (node.Find(key) == nullptr) {
      YamlNode value;
      value.place = place_;
      node.entries.push_back({key, place_, std::move(value)});
    }
    return Find(*child, *node.Find(key), rest);
  }

  YamlNode* FindInNamedMap(const SchemaNode& schema, YamlNode& node, std::string_view rest) {
    if (rest[0] == '[') return Fail("no such key; " + Consumed(rest) + " is not a list");
    if (!MakeMap(node, rest)) return nullptr;
    // Names may hold dots: the longest that fits.
    const std::string_view after_dot = rest.substr(1);
    YamlEntry* best = nullptr;
    std::vector<std::string> names;
    for (YamlEntry& entry : node.entries) {
      names.push_back(entry.key);
      const bool starts = after_dot.substr(0, entry.key.size()) == entry.key;
      const std::string_view behind = starts ? after_dot.substr(entry.key.size()) : "";
      const bool ends = behind.empty() || behind[0] == '.' || behind[0] == '[';
      if (starts && ends && (best == nullptr || entry.key.size() > best->key.size())) best = &entry;
    }
    if (best != nullptr) {
      return Find(schema.children.front(), best->value, after_dot.substr(best->key.size()));
    }
    // As many segments as a name of this map has.
    const std::string& pattern = schema.children.front().key;
    const bool dotted = pattern.find('.') != std::string::npos;
    std::string name = TakeKey(rest);
    if (dotted && !rest.empty() && rest[0] == '.') name += "." + TakeKey(rest);
    // A whole entry is added; a key of one that is not there would leave the others out.
    if (rest.empty()) {
      YamlNode value;
      value.place = place_;
      node.entries.push_back({name, place_, std::move(value)});
      return &node.entries.back().value;
    }
    return Fail("no " + pattern + " is called '" + name + "'" + NameHint(name, names));
  }

  YamlNode* FindInList(const SchemaNode& schema, YamlNode& node, std::string_view rest) {
    if (node.kind == YamlNode::Kind::kNull) node.kind = YamlNode::Kind::kList;
    if (!node.IsList()) return Fail(Consumed(rest) + " is " + DescribeNode(node) + ", not a list");
    const std::string_view before = rest;
    const std::size_t count = node.items.size();
    if (rest[0] == '[') {
      const std::size_t close = rest.find(']');
      std::size_t index = 0;
      const char* last = close == std::string_view::npos ? rest.data() : rest.data() + close;
      const auto [end, error] =
          std::from_chars(rest.data() + 1, std::max(last, rest.data() + 1), index);
      if (error != std::errc() || end != last) {
        return Fail("a list item is named by its number from 0, as in [2]");
      }
      if (index >= count) {
        return Fail(fmt::format("no item {}; {} has {}", index, Consumed(before), count));
      }
      rest.remove_prefix(close + 1);
      if (!rest.empty() && rest[0] != '.' && rest[0] != '[') {
        return Fail("'.' or '[' is expected behind ']'");
      }
      return Find(schema.children.front(), node.items[index], rest);
    }
    const std::string name = TakeKey(rest);
    std::vector<std::string> names;
    for (YamlNode& item : node.items) {
      const YamlNode* own = item.Find("name");
      if (own == nullptr) continue;
      if (own->text == name) return Find(schema.children.front(), item, rest);
      names.push_back(own->text);
    }
    return Fail("no item of " + Consumed(before) + " is called '" + name + "'" +
                NameHint(name, names));
  }

  std::string path_;
  Place place_;
  std::vector<Problem>& problems_;
};

void ApplyOverride(const SchemaNode& schema,
                   const std::vector<ConfigOverride>& overrides,
                   const Place& place,
                   YamlNode& root,
                   std::vector<Problem>& problems) {
  const auto number = static_cast<std::size_t>(place.override_index);
  const std::string& assignment = overrides[number].assignment;
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    problems.push_back({place, "", "the form is path.to.key=VALUE"});
    return;
  }
  const bool append = equals > 1 && assignment[equals - 1] == '+';
  const std::string path = assignment.substr(0, append ? equals - 1 : equals);
  const std::size_t count = problems.size();
  YamlNode value = ParseOverrideValue(assignment.substr(equals + 1), place, path, problems);
  YamlNode changed = root;
  YamlNode* target = PathWalker(path, place, problems).Find(schema, changed, "." + path);
  if (target == nullptr) return;
  if (const Place& before = target->place;
      before.source == Place::Source::kOverride && before.override_index != place.override_index) {
    // Of --set the last one counts; what varies would not, under two spellings of one key.
    const ConfigOverride& earlier = overrides[static_cast<std::size_t>(before.override_index)];
    if (earlier.varies && overrides[number].varies) {
      problems.push_back(
          {place, path, "is what " + earlier.label + " varies: " + earlier.assignment});
    }
  }
  if (!append) {
    *target = std::move(value);
  } else if (target->kind == YamlNode::Kind::kNull || target->IsList()) {
    target->kind = YamlNode::Kind::kList;
    target->items.push_back(std::move(value));
  } else {
    problems.push_back({place, path, "+= needs a list, this is " + DescribeNode(*target)});
  }
  if (problems.size() == count) root = std::move(changed);
}

}  // namespace

void ApplyOverrides(const SchemaNode& schema,
                    const std::vector<ConfigOverride>& overrides,
                    YamlNode& root,
                    std::vector<Problem>& problems) {
  if (!root.IsMap()) return;  // reported by the schema
  for (std::size_t i = 0; i < overrides.size(); ++i) {
    const Place place{Place::Source::kOverride, static_cast<int>(i), 0, 0};
    ApplyOverride(schema, overrides, place, root, problems);
  }
}

}  // namespace pathfit::app
