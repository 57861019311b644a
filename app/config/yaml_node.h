#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace pathfit::app {

/// Where a value was written. Lines and columns count from 1, columns in bytes.
struct Place {
  enum class Source { kDefault, kFile, kOverride };
  Source source = Source::kDefault;
  int override_index = 0;  ///< into ConfigSource::overrides, for kOverride
  int line = 0;
  int column = 0;
  friend bool operator==(const Place&, const Place&) = default;
};

struct YamlEntry;

/// A YAML value with the place it was read from. Trees are at most kMaxYamlDepth deep.
struct YamlNode {
  enum class Kind { kNull, kScalar, kList, kMap };
  Kind kind = Kind::kNull;
  Place place;
  std::string text;     ///< scalars: the characters, without quotes
  bool quoted = false;  ///< scalars: written in quotes, so never a number or boolean
  std::vector<YamlNode> items;
  std::vector<YamlEntry> entries;  ///< in file order; the first of duplicate keys

  /// Value of a key of a map, null if there is none (or this is no map).
  [[nodiscard]] const YamlNode* Find(std::string_view key) const;
  [[nodiscard]] YamlNode* Find(std::string_view key);
  [[nodiscard]] bool IsScalar() const { return kind == Kind::kScalar; }
  [[nodiscard]] bool IsList() const { return kind == Kind::kList; }
  [[nodiscard]] bool IsMap() const { return kind == Kind::kMap; }
};

struct YamlEntry {
  std::string key;
  Place key_place;
  YamlNode value;
};

inline constexpr int kMaxYamlDepth = 64;
inline constexpr int kMaxYamlNodes = 100000;

/// "a map", "a list", "text 'abc'", "nothing": for messages.
std::string DescribeNode(const YamlNode& node);

/// Same values, wherever they were written.
bool SameValues(const YamlNode& a, const YamlNode& b);

}  // namespace pathfit::app
