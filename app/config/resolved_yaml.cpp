#include "app/config/resolved_yaml.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace pathfit::app {
namespace {

bool IsPlainStart(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '/' || c == '+' || c == '-';
}

// Characters that never end or change a plain scalar.
bool IsPlain(const std::string& text) {
  return !text.empty() && IsPlainStart(text[0]) && text.back() != ' ' && text.rfind("--", 0) != 0 &&
         text.rfind("- ", 0) != 0 && text != "-" && text.rfind("...", 0) != 0 &&
         std::ranges::all_of(text, [](char c) { return IsPlainStart(c) || c == ' '; });
}

std::string Quote(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    switch (c) {
      case '"':
      case '\\':
        out += '\\';
        out += c;
        break;
      case '\n':
        out += "\\n";
        break;
      case '\t':
        out += "\\t";
        break;
      case '\r':
        out += "\\r";
        break;
      default:
        out += c;
    }
  }
  return out + "\"";
}

std::string WriteKey(const std::string& key) {
  const std::set<std::string> nulls = {"null", "Null", "NULL"};
  return IsPlain(key) && nulls.count(key) == 0 ? key : Quote(key);
}

bool IsFlow(const YamlNode& node) {
  constexpr std::size_t kLongList = 4;
  if (node.kind == YamlNode::Kind::kMap) return node.entries.empty();
  if (!node.IsList()) return true;
  const bool nested = !node.items.empty() && !node.items.front().IsScalar();
  return (!nested || node.items.size() <= kLongList) &&
         std::ranges::all_of(node.items,
                             [](const YamlNode& item) { return !item.IsMap() && IsFlow(item); });
}

std::string WriteFlow(const YamlNode& node) {
  if (node.IsMap()) return "{}";
  if (node.kind == YamlNode::Kind::kNull) return "null";
  if (node.IsScalar()) return node.quoted || !IsPlain(node.text) ? Quote(node.text) : node.text;
  std::string out = "[";
  for (const YamlNode& item : node.items) out += (out.size() > 1 ? ", " : "") + WriteFlow(item);
  return out + "]";
}

class Writer {
 public:
  explicit Writer(const ConfigSource& source) : source_(source) {}

  // Entries of a map; the first line starts with `first`, the others with `indent`.
  void WriteMap(const YamlNode& map, const std::string& indent, const std::string& first) {
    std::string start = first;
    for (const YamlEntry& entry : map.entries) {
      WriteValue(entry.value, start + WriteKey(entry.key) + ":", indent);
      start = indent;
    }
  }

  std::string TakeText() { return std::move(out_); }

 private:
  // `lead` ends in the key, or in the dash of a list item.
  void WriteValue(const YamlNode& value, const std::string& lead, const std::string& indent) {
    if (IsFlow(value)) {
      out_ += lead + " " + WriteFlow(value) + "  # " + Origin(value) + "\n";
      return;
    }
    out_ += lead + "\n";
    const std::string deeper = indent + "  ";
    if (value.IsMap()) {
      WriteMap(value, deeper, deeper);
      return;
    }
    for (const YamlNode& item : value.items) {
      const std::string dash = deeper + "-";
      if (item.IsMap() && !item.entries.empty()) {
        WriteMap(item, deeper + "  ", dash + " ");
      } else {
        WriteValue(item, dash, deeper);
      }
    }
  }

  [[nodiscard]] std::string OriginOf(const Place& place) const {
    switch (place.source) {
      case Place::Source::kDefault:
        return "default";
      case Place::Source::kOverride:
        return source_.overrides[static_cast<std::size_t>(place.override_index)].label;
      case Place::Source::kFile:
        break;
    }
    const std::string name = std::filesystem::path(source_.file).filename().string();
    return fmt::format("{}:{}", name, place.line);
  }

  // Where the value was written; a list that was changed afterwards has two places or more.
  [[nodiscard]] std::string Origin(const YamlNode& node) const {
    std::vector<std::string> origins = {OriginOf(node.place)};
    for (const YamlNode& item : node.items) {
      const std::string origin = OriginOf(item.place);
      if (item.place.source == Place::Source::kOverride &&
          std::ranges::find(origins, origin) == origins.end()) {
        origins.push_back(origin);
      }
    }
    std::string out;
    for (const std::string& origin : origins) out += (out.empty() ? "" : ", ") + origin;
    std::ranges::replace_if(
        out, [](char c) { return c >= 0 && c < ' '; }, '?');
    return out;
  }

  const ConfigSource& source_;
  std::string out_;
};

}  // namespace

std::string WritePlacedYaml(const YamlNode& root, const ConfigSource& source) {
  Writer writer(source);
  writer.WriteMap(root, "", "");
  return writer.TakeText();
}

std::string WriteResolvedYaml(const YamlNode& root, const ConfigSource& source) {
  return "# Every value of the run and where it was written. This file can be run again.\n" +
         WritePlacedYaml(root, source);
}

}  // namespace pathfit::app
