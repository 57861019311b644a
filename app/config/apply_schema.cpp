#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "app/config/nearest_name.h"
#include "app/config/scalar.h"
#include "app/config/schema.h"
#include "app/config/yaml_document.h"

namespace pathfit::app {
namespace {

using Type = SchemaNode::Type;
using Presence = SchemaNode::Presence;

bool IsName(const std::string& text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

bool InRange(const NumberRange& range, double value) {
  const bool above = range.lower_open ? value > range.lower : value >= range.lower;
  const bool below = range.upper_open ? value < range.upper : value <= range.upper;
  return above && below;
}

constexpr const char* kNameRule = "may hold only letters, digits, '_' and '-'";

// Keys that depend on the value of another key of the map (`when_key`), given or by default.

// Value of the key that decides about `child`, which must have one.
std::string DiscriminatorOf(const SchemaNode& map, const SchemaNode& child, const YamlNode& node) {
  const YamlNode* value = node.Find(child.when_key);
  return value != nullptr ? value->text : map.Child(child.when_key)->default_yaml;
}

// Whether that value is one of those possible; true for keys that depend on nothing.
bool IsDiscriminatorKnown(const SchemaNode& map, const SchemaNode& child, const YamlNode& node) {
  return child.when_key.empty() ||
         Contains(map.Child(child.when_key)->words, DiscriminatorOf(map, child, node));
}

// Whether the key belongs to this map. Unknown or missing values rule nothing out.
bool BelongsTo(const SchemaNode& map, const SchemaNode& child, const YamlNode& node) {
  return child.when_key.empty() || !IsDiscriminatorKnown(map, child, node) ||
         Contains(child.when_values, DiscriminatorOf(map, child, node));
}

// Whether the key must be given, alone or as one of its group.
bool IsRequired(const SchemaNode& map, const SchemaNode& child, const YamlNode& node) {
  return child.presence == SchemaNode::Presence::kRequired &&
         (child.required_values.empty() ||
          Contains(child.required_values, DiscriminatorOf(map, child, node)));
}

bool IsGroupRequired(const SchemaNode& map, const SchemaNode& child, const YamlNode& node) {
  return child.one_of_values.empty() ||
         Contains(child.one_of_values, DiscriminatorOf(map, child, node));
}

// A value and the line of the schema that it must follow.
struct Spot {
  const SchemaNode& schema;
  YamlNode& node;
  const std::string& path;
  /// What messages say is needed: the schema itself, or all alternatives of which it is one.
  const SchemaNode& allowed;
};

class Applier {
 public:
  Applier(const std::filesystem::path& folder, std::vector<Problem>& problems)
      : folder_(folder), problems_(problems) {}

  // False if the value is wrong.
  bool Apply(const SchemaNode& schema, YamlNode& node, const std::string& path) {
    return Apply({schema, node, path, schema});
  }

 private:
  bool Apply(const Spot& at) {
    const bool is_word = Contains(at.schema.words, at.node.text);
    switch (at.schema.type) {
      case Type::kMap:
        return ApplyMap(at);
      case Type::kNamedMap:
        return ApplyNamedMap(at);
      case Type::kList:
        return ApplyList(at);
      case Type::kEither:
        for (const SchemaNode& form : at.schema.children) {
          if (FitsForm(form, at.node)) return Apply({form, at.node, at.path, at.schema});
        }
        return WrongType(at);
      default:
        break;
    }
    if (!at.node.IsScalar()) return WrongType(at);
    switch (at.schema.type) {
      case Type::kBool:
        return Accept(ParseBool(at.node), at);
      case Type::kInteger:
        return is_word || ApplyRange(at, ParseInteger(at.node));
      case Type::kNumber:
        return is_word || ApplyRange(at, ParseNumber(at.node, at.schema.range.allow_infinite));
      case Type::kBytes:
        return is_word || Accept(ParseBytes(at.node), at);
      case Type::kPath:
        return is_word || ApplyPath(at);
      case Type::kChoice:
        return is_word || RefuseChoice(at);
      case Type::kName:
        return IsName(at.node.text) || Report(at, DescribeNode(at.node) + " " + kNameRule);
      default:
        return !at.node.text.empty() || Report(at, "text is needed, not \"\"");
    }
  }

  bool Report(const Place& place, const std::string& path, std::string text) {
    problems_.push_back({place, path, std::move(text)});
    return false;
  }
  bool Report(const Spot& at, std::string text) {
    return Report(at.node.place, at.path, std::move(text));
  }

  void ReportMissing(const SchemaNode& child, const Spot& map) {
    Report(map, "required key '" + child.key + "' is missing (" + DescribeType(child) + ")");
  }

  bool WrongType(const Spot& at) {
    std::vector<std::string> keys;
    const auto depends = [](const SchemaNode& child) { return !child.when_key.empty(); };
    // Which a map has may depend on others of its keys.
    if (at.allowed.type == Type::kMap && std::ranges::none_of(at.allowed.children, depends)) {
      for (const SchemaNode& child : at.allowed.children) keys.push_back(child.key);
    }
    return Report(at,
                  DescribeType(at.allowed) + " is needed, not " + DescribeNode(at.node) +
                      KeyThatTakes(at) + NameHint("", keys));
  }

  /// Advice where a value stands in place of a map of one key: which of its keys takes it.
  [[nodiscard]] std::string KeyThatTakes(const Spot& at) const {
    if (at.allowed.type != Type::kMap) return "";
    for (const SchemaNode& child : at.allowed.children) {
      const bool may_stand_alone = !child.one_of.empty() || at.allowed.children.size() == 1;
      if (!may_stand_alone || child.type == Type::kMap) continue;
      YamlNode value = at.node;
      std::vector<Problem> ignored;
      if (!Applier(folder_, ignored).Apply(child, value, at.path)) continue;
      return "; write {" + child.key + ": " + (value.IsScalar() ? at.node.text : "[...]") + "}";
    }
    return "";
  }

  template <class T>
  bool Accept(const Parsed<T>& parsed, const Spot& at) {
    return parsed.value ? true : Report(at, parsed.problem);
  }

  template <class T>
  bool ApplyRange(const Spot& at, const Parsed<T>& parsed) {
    const auto allowed = [&at] { return " (allowed: " + DescribeType(at.allowed) + ")"; };
    // Words, if any, are part of what could have been meant.
    if (!parsed.value) {
      return Report(at, parsed.problem + (at.schema.words.empty() ? "" : allowed()));
    }
    const auto value = static_cast<double>(*parsed.value);
    constexpr double kExact = 0x1p53;  // above, a whole number may be rounded into the range
    const bool is_rounded = std::abs(value) <= kExact && static_cast<T>(value) != *parsed.value;
    if (!at.schema.has_range || (InRange(at.schema.range, value) && !is_rounded)) return true;
    return Report(at, at.node.text + " is out of range" + allowed());
  }

  bool ApplyPath(const Spot& at) {
    const Parsed<std::filesystem::path> parsed = ResolvePath(at.node.text, folder_);
    if (!parsed.value) return Report(at, parsed.problem);
    at.node.text = parsed.value->string();
    at.node.quoted = true;
    return true;
  }

  bool RefuseChoice(const Spot& at) {
    if (const std::string* advice = at.schema.AdviceFor(at.node.text)) {
      return Report(at, DescribeNode(at.node) + " is not supported" + *advice);
    }
    const std::string nearest = NearestName(at.node.text, at.schema.words);
    return Report(at,
                  DescribeNode(at.node) + " is not allowed; " + DescribeType(at.allowed) +
                      " is needed" + (nearest.empty() ? "" : " (did you mean '" + nearest + "'?)"));
  }

  bool ApplyList(const Spot& at) {
    if (!at.node.IsList()) return WrongType(at);
    std::vector<YamlNode>& items = at.node.items;
    const auto count = static_cast<int>(items.size());
    if (count < at.schema.min_items || (at.schema.max_items > 0 && count > at.schema.max_items)) {
      const char* plural = count == 1 ? "" : "s";
      return Report(
          at, fmt::format("{} is needed, not {} item{}", DescribeType(at.allowed), count, plural));
    }
    const SchemaNode& item = at.schema.children.front();
    bool valid = true;
    std::set<std::string> before;
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (at.schema.distinct && !before.insert(items[i].text).second) {
        Report(items[i].place, at.path, "'" + items[i].text + "' is given twice");
      }
      if (Apply(item, items[i], fmt::format("{}[{}]", at.path, i))) continue;
      if (item.type == Type::kMap) {
        items[i].kind = YamlNode::Kind::kNull;
      } else {
        valid = false;
      }
    }
    return valid;
  }

  bool ApplyNamedMap(const Spot& at) {
    if (!at.node.IsMap()) return WrongType(at);
    const SchemaNode& item = at.schema.children.front();
    if (static_cast<int>(at.node.entries.size()) < at.schema.min_items) {
      return Report(at, "at least one " + item.key + " is needed");
    }
    for (YamlEntry& entry : at.node.entries) {
      if (!at.schema.free_names && !IsName(entry.key)) {
        Report(entry.key_place, at.path, "the name '" + entry.key + "' " + kNameRule);
      }
      if (!Apply(item, entry.value, JoinPath(at.path, entry.key))) {
        entry.value.kind = YamlNode::Kind::kNull;
      }
    }
    return true;
  }

  // False if the entry must go. `given` collects the keys that were written or meant.
  bool ApplyEntry(const Spot& map, YamlEntry& entry, std::set<std::string>& given) {
    const auto report = [&](std::string text) {
      return Report(entry.key_place, map.path, std::move(text));
    };
    const SchemaNode* child = map.schema.Child(entry.key);
    if (child == nullptr) {
      if (const std::string* advice = map.schema.AdviceFor(entry.key)) {
        return report("key '" + entry.key + "' is not supported" + *advice);
      }
      std::vector<std::string> keys;
      std::vector<std::string> all_keys;
      for (const SchemaNode& c : map.schema.children) {
        all_keys.push_back(c.key);
        if (BelongsTo(map.schema, c, map.node)) keys.push_back(c.key);
      }
      const std::string nearest = NearestName(entry.key, keys);
      given.insert(nearest);
      const bool elsewhere = nearest.empty() && !NearestName(entry.key, all_keys).empty();
      return report("unknown key '" + entry.key + "'" +
                    NameHint(entry.key, elsewhere ? all_keys : keys));
    }
    given.insert(entry.key);
    if (!BelongsTo(map.schema, *child, map.node)) {
      return report(fmt::format("key '{}' does not belong to {} '{}', only to {}",
                                entry.key,
                                child->when_key,
                                DiscriminatorOf(map.schema, *child, map.node),
                                JoinNames(child->when_values)));
    }
    if (!child->needs.empty() && map.node.Find(child->needs) == nullptr) {
      return report("key '" + entry.key + "' needs key '" + child->needs + "'");
    }
    return Apply(*child, entry.value, JoinPath(map.path, entry.key));
  }

  // Of keys that exclude each other. `given`: as ApplyEntry.
  void ReportGroups(const Spot& map, const std::set<std::string>& given) {
    std::vector<std::string> done;
    for (const SchemaNode& child : map.schema.children) {
      if (child.one_of.empty() || Contains(done, child.one_of)) continue;
      if (!IsDiscriminatorKnown(map.schema, child, map.node)) continue;
      if (!BelongsTo(map.schema, child, map.node)) continue;
      done.push_back(child.one_of);
      std::vector<std::string> members;
      bool meant = false;
      for (const SchemaNode& other : map.schema.children) {
        if (other.one_of != child.one_of || !BelongsTo(map.schema, other, map.node)) continue;
        members.push_back(other.key);
        meant = meant || given.count(other.key) > 0;
      }
      std::string first;
      for (const YamlEntry& entry : map.node.entries) {
        if (!Contains(members, entry.key)) continue;
        if (first.empty()) {
          first = entry.key;
          continue;
        }
        Report(entry.key_place,
               map.path,
               fmt::format("'{}' and '{}' cannot be given together", entry.key, first));
      }
      if (meant || !IsGroupRequired(map.schema, child, map.node)) continue;
      if (members.size() == 1) {
        ReportMissing(*map.schema.Child(members.front()), map);
      } else {
        Report(map, "one of the keys " + JoinNames(members) + " is needed");
      }
    }
  }

  void FillDefaults(const Spot& map, const std::set<std::string>& given) {
    for (const SchemaNode& child : map.schema.children) {
      if (map.node.Find(child.key) != nullptr) continue;
      if (!IsDiscriminatorKnown(map.schema, child, map.node)) continue;
      if (!BelongsTo(map.schema, child, map.node)) continue;
      const bool required = IsRequired(map.schema, child, map.node);
      if (required && given.count(child.key) == 0) ReportMissing(child, map);
      const bool defaulted =
          child.presence == Presence::kDefaulted ||
          (child.presence == Presence::kRequired && !required && !child.default_yaml.empty());
      const bool needed = child.needs.empty() || map.node.Find(child.needs) != nullptr;
      if (!defaulted || !needed) continue;
      YamlNode value = DefaultValue(child.default_yaml.empty() ? "{}" : child.default_yaml);
      Apply(child, value, JoinPath(map.path, child.key));
      map.node.entries.push_back({child.key, Place{}, std::move(value)});
    }
  }

  bool ApplyMap(const Spot& at) {
    if (!at.node.IsMap()) return WrongType(at);
    std::set<std::string> given;
    std::vector<YamlEntry> kept;
    YamlNode written = at.node;
    const Spot map{at.schema, written, at.path, at.allowed};
    for (YamlEntry& entry : at.node.entries) {
      if (ApplyEntry(map, entry, given)) kept.push_back(std::move(entry));
    }
    at.node.entries = std::move(kept);
    ReportGroups(map, given);
    FillDefaults(at, given);
    return true;
  }

  const std::filesystem::path& folder_;
  std::vector<Problem>& problems_;
};

}  // namespace

bool FitsForm(const SchemaNode& form, const YamlNode& node) {
  return form.type == Type::kList                                  ? node.IsList()
         : form.type == Type::kMap || form.type == Type::kNamedMap ? node.IsMap()
                                                                   : node.IsScalar();
}

YamlNode DefaultValue(const std::string& yaml) {
  if (yaml.find_first_of("[{\"'") == std::string::npos) {
    YamlNode scalar;
    scalar.kind = YamlNode::Kind::kScalar;
    scalar.text = yaml;
    return scalar;
  }
  std::vector<Problem> problems;
  return ParseOverrideValue(yaml, Place{}, "", problems);
}

std::string JoinPath(const std::string& path, const std::string& key) {
  return path.empty() ? key : path + "." + key;
}

void ApplySchema(const SchemaNode& schema,
                 const std::filesystem::path& folder,
                 YamlNode& root,
                 std::vector<Problem>& problems) {
  Applier applier(folder, problems);
  if (!applier.Apply(schema, root, "")) root = DefaultValue("{}");
}

}  // namespace pathfit::app
