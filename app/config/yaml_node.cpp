#include "app/config/yaml_node.h"

#include <algorithm>

namespace pathfit::app {

const YamlNode* YamlNode::Find(std::string_view key) const {
  const auto found =
      std::ranges::find_if(entries, [key](const YamlEntry& entry) { return entry.key == key; });
  return found == entries.end() ? nullptr : &found->value;
}

YamlNode* YamlNode::Find(std::string_view key) {
  const auto found =
      std::ranges::find_if(entries, [key](const YamlEntry& entry) { return entry.key == key; });
  return found == entries.end() ? nullptr : &found->value;
}

std::string DescribeNode(const YamlNode& node) {
  switch (node.kind) {
    case YamlNode::Kind::kNull:
      return "nothing";
    case YamlNode::Kind::kList:
      return "a list";
    case YamlNode::Kind::kMap:
      return "a map";
    case YamlNode::Kind::kScalar:
      break;
  }
  constexpr std::size_t kMaxShown = 60;
  const std::string shown =
      node.text.size() > kMaxShown ? node.text.substr(0, kMaxShown) + "…" : node.text;
  return node.quoted ? "\"" + shown + "\"" : "'" + shown + "'";
}

bool SameValues(const YamlNode& a, const YamlNode& b) {
  return a.kind == b.kind && a.text == b.text &&
         std::equal(a.items.begin(), a.items.end(), b.items.begin(), b.items.end(), SameValues) &&
         std::equal(a.entries.begin(),
                    a.entries.end(),
                    b.entries.begin(),
                    b.entries.end(),
                    [](const YamlEntry& x, const YamlEntry& y) {
                      return x.key == y.key && SameValues(x.value, y.value);
                    });
}

}  // namespace pathfit::app
