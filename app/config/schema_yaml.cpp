#include <algorithm>
#include <cctype>

#include <fmt/format.h>

#include "app/config/nearest_name.h"
#include "app/config/schema.h"
#include "app/config/wrapped_words.h"

namespace pathfit::app {
namespace {

using Type = SchemaNode::Type;
using Presence = SchemaNode::Presence;

constexpr std::size_t kWidth = 100;
constexpr int kNone = -1;

/// Whether the key takes its default in a map of nothing but defaults.
bool IsDefaulted(const SchemaNode& map, const SchemaNode& key) {
  if (!key.needs.empty()) return false;
  return key.when_key.empty() || Contains(key.when_values, map.Child(key.when_key)->default_yaml);
}

/// Whether there is anything to write of it without '#'.
bool IsActive(const SchemaNode& map, const SchemaNode& node) {
  if (node.key == "schema") return true;
  const bool is_open = node.presence == Presence::kDefaulted ||
                       (node.type == Type::kMap && node.presence == Presence::kRequired);
  if (!is_open || !IsDefaulted(map, node)) return false;
  if (!node.default_yaml.empty()) return true;
  return node.type == Type::kMap &&
         std::ranges::any_of(node.children,
                             [&](const SchemaNode& child) { return IsActive(node, child); });
}

/// What stands for a value that has no default.
std::string Placeholder(const SchemaNode& node) {
  switch (node.type) {
    case Type::kBool:
      return "true";
    case Type::kInteger:
    case Type::kNumber:
      return "NUMBER";
    case Type::kChoice:
      return node.words.front();
    case Type::kPath:
      return "PATH";
    case Type::kBytes:
      return "16 GiB";
    case Type::kList: {
      std::string items;
      for (int i = 0; i < std::max(1, node.min_items); ++i) {
        items += (i > 0 ? ", " : "") + Placeholder(node.children.front());
      }
      return "[" + items + "]";
    }
    case Type::kMap:
    case Type::kNamedMap:
      return "{}";
    case Type::kEither:
      return Placeholder(node.children.front());
    default:
      return "TEXT";
  }
}

class Writer {
 public:
  void WriteMap(const SchemaNode& map, int level, int commented) {
    for (const SchemaNode& child : map.children) WriteKey(map, child, level, commented);
  }
  std::string text;

 private:
  /// `commented`: the level of the outermost key behind '#', or kNone.
  void Line(int level, int commented, const std::string& line) {
    const auto spaces = [](int count) { return std::string(static_cast<std::size_t>(count), ' '); };
    text += commented == kNone ? spaces(2 * level)
                               : spaces(2 * commented) + "# " + spaces(2 * (level - commented));
    text += line + "\n";
  }

  void Comment(int level, int commented, const std::string& comment) {
    const std::size_t before = 2 * static_cast<std::size_t>(level) + 2;  // and "# "
    for (const std::string& line : WrappedWords(comment, kWidth - before)) {
      Line(level, commented, "# " + line);
    }
  }

  static std::string CommentOf(const SchemaNode& map, const SchemaNode& node) {
    std::string comment = node.doc + (node.doc.empty() ? "" : " ") + "(" + DescribeType(node);
    if (!node.unit.empty()) comment += ", " + node.unit;
    if (!node.when_key.empty() &&
        node.when_values.size() < map.Child(node.when_key)->words.size()) {
      comment += "; only for " + node.when_key + " " + JoinNames(node.when_values);
    }
    if (!node.needs.empty()) comment += "; only with " + node.needs;
    if (node.presence == Presence::kRequired && node.required_values.empty()) {
      comment += "; required";
    } else if (node.presence == Presence::kRequired) {
      comment += "; required for " + JoinNames(node.required_values);
    } else if (!node.default_doc.empty()) {
      comment += "; default: " + node.default_doc;
    }
    return comment + ")";
  }

  void WriteKey(const SchemaNode& map, const SchemaNode& node, int level, int commented) {
    if (level == 0) text += "\n";
    Comment(level, commented, CommentOf(map, node));
    if (commented == kNone && !IsActive(map, node)) commented = level;
    const bool has_keys = node.type == Type::kMap || node.type == Type::kNamedMap ||
                          (node.type == Type::kList && node.children.front().type == Type::kMap);
    if (has_keys && node.default_yaml.empty()) {
      Line(level, commented, node.key + ":");
      WriteBelow(node, level + 1, commented);
      return;
    }
    const std::string value = node.key == "schema"        ? "1"
                              : node.default_yaml.empty() ? Placeholder(node)
                                                          : node.default_yaml;
    Line(level, commented, node.key + ": " + value);
    if (node.type != Type::kEither) return;
    for (const SchemaNode& form : node.children) {
      if (form.type != Type::kMap) continue;
      const int alternative = commented == kNone ? level : commented;
      Line(level, alternative, "# or: " + node.key + ":");
      WriteMap(form, level + 1, alternative);
    }
  }

  void WriteBelow(const SchemaNode& node, int level, int commented) {
    if (node.type == Type::kMap) return WriteMap(node, level, commented);
    const SchemaNode& item = node.children.front();
    if (node.type == Type::kList) {
      Line(level, commented, "-");
      return WriteMap(item, level + 1, commented);
    }
    if (item.type != Type::kMap) return Line(level, commented, item.key + ": " + Placeholder(item));
    Line(level, commented, item.key + ":");
    WriteMap(item, level + 1, commented);
  }
};

}  // namespace

std::string SchemaYaml() {
  Writer writer;
  writer.text =
      "# Every setting of a config, with its default. What stands behind '#' has none, or is not "
      "used unless it is given.\n# Names in CAPITALS are yours to choose. A config needs few of "
      "these: pathfit init writes one for your photos.\n";
  writer.WriteMap(ConfigSchema(), 0, kNone);
  return writer.text;
}

}  // namespace pathfit::app
