#include "app/config/apply_schema.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "app/config/config_path.h"
#include "app/config/nearest_name.h"
#include "app/config/scalar.h"
#include "app/config/yaml_document.h"

namespace pathfit::app {
namespace {

using Type = SchemaNode::Type;
using Presence = SchemaNode::Presence;

bool Contains(const std::vector<std::string>& list, const std::string& text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

const Unsupported* FindUnsupported(const SchemaNode& schema, const std::string& name) {
  const auto found = std::find_if(schema.unsupported.begin(),
                                  schema.unsupported.end(),
                                  [&](const Unsupported& u) { return u.name == name; });
  return found == schema.unsupported.end() ? nullptr : &*found;
}

bool IsName(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
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

class Applier {
 public:
  Applier(const std::filesystem::path& folder, std::vector<Problem>& problems)
      : folder_(folder), problems_(problems) {}

  // False if the value is wrong. `allowed` is what messages say is needed: the schema itself, or
  // all alternatives of which it is one.
  bool Apply(const SchemaNode& schema,
             YamlNode& node,
             const std::string& path,
             const SchemaNode& allowed) {
    switch (schema.type) {
      case Type::kMap:
        return ApplyMap(schema, node, path, allowed);
      case Type::kNamedMap:
        return ApplyNamedMap(schema, node, path);
      case Type::kList:
        return ApplyList(schema, node, path, allowed);
      case Type::kEither:
        return ApplyEither(schema, node, path);
      default:
        break;
    }
    if (!node.IsScalar()) return WrongType(allowed, node, path);
    switch (schema.type) {
      case Type::kBool:
        return Accept(ParseBool(node), node, path);
      case Type::kInteger:
        if (IsWord(schema, node)) return true;
        return ApplyRange(schema, ParseInteger(node), node, path, allowed);
      case Type::kNumber:
        if (IsWord(schema, node)) return true;
        return ApplyRange(
            schema, ParseNumber(node, schema.range.allow_infinite), node, path, allowed);
      case Type::kBytes:
        return IsWord(schema, node) || Accept(ParseBytes(node), node, path);
      case Type::kPath:
        return IsWord(schema, node) || ApplyPath(node, path);
      case Type::kChoice:
        return ApplyChoice(schema, node, path, allowed);
      case Type::kName:
        if (IsName(node.text)) return true;
        return Report(node.place, path, DescribeNode(node) + " " + kNameRule);
      default:
        if (!node.text.empty()) return true;
        return Report(node.place, path, "text is needed, not \"\"");
    }
  }

 private:
  bool Report(const Place& place, const std::string& path, std::string text) {
    problems_.push_back({place, path, std::move(text)});
    return false;
  }

  void ReportMissing(const SchemaNode& child, const YamlNode& node, const std::string& path) {
    Report(node.place,
           path,
           "required key '" + child.key + "' is missing (" + DescribeType(child) + ")");
  }

  bool WrongType(const SchemaNode& allowed, const YamlNode& node, const std::string& path) {
    return Report(
        node.place, path, DescribeType(allowed) + " is needed, not " + DescribeNode(node));
  }

  static bool IsWord(const SchemaNode& schema, const YamlNode& node) {
    return Contains(schema.words, node.text);
  }

  template <class T>
  bool Accept(const Parsed<T>& parsed, const YamlNode& node, const std::string& path) {
    return parsed.value ? true : Report(node.place, path, parsed.problem);
  }

  template <class T>
  bool ApplyRange(const SchemaNode& schema,
                  const Parsed<T>& parsed,
                  const YamlNode& node,
                  const std::string& path,
                  const SchemaNode& allowed) {
    if (!parsed.value) {
      // Words, if any, are part of what could have been meant.
      const std::string words =
          schema.words.empty() ? "" : " (allowed: " + DescribeType(allowed) + ")";
      return Report(node.place, path, parsed.problem + words);
    }
    if (!schema.has_range || InRange(schema.range, static_cast<double>(*parsed.value))) return true;
    return Report(
        node.place, path, node.text + " is out of range (allowed: " + DescribeType(allowed) + ")");
  }

  bool ApplyPath(YamlNode& node, const std::string& path) {
    const Parsed<std::filesystem::path> parsed = ResolvePath(node.text, folder_);
    if (!parsed.value) return Report(node.place, path, parsed.problem);
    node.text = parsed.value->string();
    node.quoted = true;
    return true;
  }

  bool ApplyChoice(const SchemaNode& schema,
                   const YamlNode& node,
                   const std::string& path,
                   const SchemaNode& allowed) {
    if (IsWord(schema, node)) return true;
    if (const Unsupported* known = FindUnsupported(schema, node.text)) {
      return Report(node.place, path, DescribeNode(node) + " is not supported" + known->advice);
    }
    const std::string nearest = NearestName(node.text, schema.words);
    return Report(node.place,
                  path,
                  DescribeNode(node) + " is not allowed; " + DescribeType(allowed) + " is needed" +
                      (nearest.empty() ? "" : " (did you mean '" + nearest + "'?)"));
  }

  bool ApplyEither(const SchemaNode& schema, YamlNode& node, const std::string& path) {
    for (const SchemaNode& form : schema.children) {
      if (FitsForm(form, node)) return Apply(form, node, path, schema);
    }
    return WrongType(schema, node, path);
  }

  bool ApplyList(const SchemaNode& schema,
                 YamlNode& node,
                 const std::string& path,
                 const SchemaNode& allowed) {
    if (!node.IsList()) return WrongType(allowed, node, path);
    const auto count = static_cast<int>(node.items.size());
    if (count < schema.min_items || (schema.max_items > 0 && count > schema.max_items)) {
      return Report(
          node.place,
          path,
          fmt::format(
              "{} is needed, not {} item{}", DescribeType(allowed), count, count == 1 ? "" : "s"));
    }
    const SchemaNode& item = schema.children.front();
    bool valid = true;
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const auto first = node.items.begin();
      const auto here = first + static_cast<std::ptrdiff_t>(i);
      if (schema.distinct && std::any_of(first, here, [&](const YamlNode& before) {
            return before.text == here->text;
          })) {
        Report(here->place, path, "'" + here->text + "' is given twice");
      }
      if (Apply(item, node.items[i], fmt::format("{}[{}]", path, i), item)) continue;
      if (item.type == Type::kMap) {
        node.items[i].kind = YamlNode::Kind::kNull;
      } else {
        valid = false;
      }
    }
    return valid;
  }

  bool ApplyNamedMap(const SchemaNode& schema, YamlNode& node, const std::string& path) {
    if (!node.IsMap()) return WrongType(schema, node, path);
    const SchemaNode& item = schema.children.front();
    if (static_cast<int>(node.entries.size()) < schema.min_items) {
      return Report(node.place, path, "at least one " + item.key + " is needed");
    }
    for (YamlEntry& entry : node.entries) {
      if (!schema.free_names && !IsName(entry.key)) {
        Report(entry.key_place, path, "the name '" + entry.key + "' " + kNameRule);
      }
      if (!Apply(item, entry.value, JoinPath(path, entry.key), item)) {
        entry.value.kind = YamlNode::Kind::kNull;
      }
    }
    return true;
  }

  bool ApplyMap(const SchemaNode& schema,
                YamlNode& node,
                const std::string& path,
                const SchemaNode& allowed);
  bool ApplyEntry(const SchemaNode& schema,
                  YamlEntry& entry,
                  const YamlNode& node,
                  const std::string& path,
                  std::set<std::string>& given);
  void ReportGroups(const SchemaNode& schema,
                    const YamlNode& node,
                    const std::vector<std::pair<std::string, Place>>& groups_given,
                    const std::set<std::string>& given,
                    const std::string& path);
  void FillDefaults(const SchemaNode& schema,
                    YamlNode& node,
                    const std::string& path,
                    const std::set<std::string>& given);

  const std::filesystem::path& folder_;
  std::vector<Problem>& problems_;
};

// False if the entry must go. `given` collects the keys that were written or meant.
bool Applier::ApplyEntry(const SchemaNode& schema,
                         YamlEntry& entry,
                         const YamlNode& node,
                         const std::string& path,
                         std::set<std::string>& given) {
  const SchemaNode* child = schema.Child(entry.key);
  if (child == nullptr) {
    if (const Unsupported* known = FindUnsupported(schema, entry.key)) {
      return Report(
          entry.key_place, path, "key '" + entry.key + "' is not supported" + known->advice);
    }
    std::vector<std::string> keys;
    std::vector<std::string> all_keys;
    for (const SchemaNode& c : schema.children) {
      all_keys.push_back(c.key);
      if (BelongsTo(schema, c, node)) keys.push_back(c.key);
    }
    const std::string nearest = NearestName(entry.key, keys);
    given.insert(nearest);
    return Report(
        entry.key_place,
        path,
        "unknown key '" + entry.key + "'" +
            NameHint(
                entry.key,
                nearest.empty() && !NearestName(entry.key, all_keys).empty() ? all_keys : keys));
  }
  given.insert(entry.key);
  if (!BelongsTo(schema, *child, node)) {
    const YamlNode* value = node.Find(child->when_key);
    return Report(entry.key_place,
                  path,
                  fmt::format("key '{}' does not belong to {} '{}', only to {}",
                              entry.key,
                              child->when_key,
                              value->text,
                              JoinNames(child->when_values)));
  }
  if (!child->needs.empty() && node.Find(child->needs) == nullptr) {
    return Report(
        entry.key_place, path, "key '" + entry.key + "' needs key '" + child->needs + "'");
  }
  return Apply(*child, entry.value, JoinPath(path, entry.key), *child);
}

void Applier::ReportGroups(const SchemaNode& schema,
                           const YamlNode& node,
                           const std::vector<std::pair<std::string, Place>>& groups_given,
                           const std::set<std::string>& given,
                           const std::string& path) {
  std::vector<std::string> done;
  for (const SchemaNode& child : schema.children) {
    if (child.one_of.empty() || Contains(done, child.one_of)) continue;
    if (!IsDiscriminatorKnown(schema, child, node) || !BelongsTo(schema, child, node)) continue;
    done.push_back(child.one_of);
    std::vector<std::string> members;
    bool meant = false;
    for (const SchemaNode& other : schema.children) {
      if (other.one_of != child.one_of || !BelongsTo(schema, other, node)) continue;
      members.push_back(other.key);
      meant = meant || given.count(other.key) > 0;
    }
    std::string first;
    for (const auto& [key, place] : groups_given) {
      if (!Contains(members, key)) continue;
      if (!first.empty()) {
        Report(place, path, fmt::format("'{}' and '{}' cannot be given together", key, first));
      } else {
        first = key;
      }
    }
    if (meant || !IsGroupRequired(schema, child, node)) continue;
    if (members.size() == 1) {
      ReportMissing(*schema.Child(members.front()), node, path);
    } else {
      Report(node.place, path, "one of the keys " + JoinNames(members) + " is needed");
    }
  }
}

void Applier::FillDefaults(const SchemaNode& schema,
                           YamlNode& node,
                           const std::string& path,
                           const std::set<std::string>& given) {
  for (const SchemaNode& child : schema.children) {
    if (node.Find(child.key) != nullptr || !IsDiscriminatorKnown(schema, child, node) ||
        !BelongsTo(schema, child, node)) {
      continue;
    }
    const bool required = IsRequired(schema, child, node);
    if (required && given.count(child.key) == 0) ReportMissing(child, node, path);
    const bool defaulted =
        child.presence == Presence::kDefaulted ||
        (child.presence == Presence::kRequired && !required && !child.default_yaml.empty());
    const bool needed = child.needs.empty() || node.Find(child.needs) != nullptr;
    if (!defaulted || !needed) continue;
    YamlNode value;
    value.kind = YamlNode::Kind::kMap;
    if (!child.default_yaml.empty()) value = DefaultValue(child.default_yaml);
    Apply(child, value, JoinPath(path, child.key), child);
    node.entries.push_back({child.key, Place{}, std::move(value)});
  }
}

bool Applier::ApplyMap(const SchemaNode& schema,
                       YamlNode& node,
                       const std::string& path,
                       const SchemaNode& allowed) {
  if (!node.IsMap()) return WrongType(allowed, node, path);
  std::set<std::string> given;
  std::vector<std::pair<std::string, Place>> keys;
  std::vector<YamlEntry> kept;
  const YamlNode written = node;
  for (YamlEntry& entry : node.entries) {
    keys.emplace_back(entry.key, entry.key_place);
    if (ApplyEntry(schema, entry, written, path, given)) kept.push_back(std::move(entry));
  }
  node.entries = std::move(kept);
  ReportGroups(schema, written, keys, given, path);
  FillDefaults(schema, node, path, given);
  return true;
}

}  // namespace

bool FitsForm(const SchemaNode& form, const YamlNode& node) {
  return form.type == Type::kList  ? node.IsList()
         : form.type == Type::kMap ? node.IsMap()
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
  if (!applier.Apply(schema, root, "", schema)) root = DefaultValue("{}");
}

}  // namespace pathfit::app
