#include "app/config/yaml_document.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include "app/config/utf8.h"

namespace pathfit::app {
namespace {

constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{16} << 20U;

// Reading cannot go on.
struct YamlFailure {
  Place place;
  std::string text;
};

std::vector<std::string> SplitLines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    lines.push_back(std::move(line));
  }
  return lines;
}

// The parser takes some tabs for spaces and others for text; none is meant.
void RefuseTabs(const std::vector<std::string>& lines) {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::size_t text = lines[i].find_first_not_of(" \t");
    const std::size_t tab = lines[i].find('\t');
    if (text != std::string::npos && lines[i][text] != '#' && tab < text) {
      throw YamlFailure{
          {Place::Source::kFile, 0, static_cast<int>(i) + 1, static_cast<int>(tab) + 1},
          "a tab is used for indentation; use spaces"};
    }
  }
}

void RefuseBinary(const std::string& text) {
  const std::optional<std::size_t> bad = FirstBadByte(text);
  if (!bad) return;
  const auto line =
      1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(*bad), '\n');
  const std::size_t line_start = *bad == 0 ? std::string::npos : text.rfind('\n', *bad - 1);
  const std::size_t column = line_start == std::string::npos ? *bad + 1 : *bad - line_start;
  throw YamlFailure{
      {Place::Source::kFile, 0, static_cast<int>(line), static_cast<int>(column)},
      "this is not UTF-8 text (byte " +
          std::to_string(static_cast<unsigned>(static_cast<unsigned char>(text[*bad]))) + ")"};
}

Place PlaceOf(const YAML::Mark& mark) {
  return {Place::Source::kFile, 0, mark.line + 1, mark.column + 1};
}

// Builds the tree from parser events, so that duplicate keys, quotes and places are seen before
// anything is lost.
class TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(const std::string& text) : text_(text) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (finished_) {
      throw YamlFailure{PlaceOf(mark),
                        "a second document starts here; a config is one document whose keys "
                        "start in the same column"};
    }
  }
  void OnDocumentEnd() override { finished_ = true; }
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    YamlNode node;
    node.place = PlaceOf(mark);
    // The parser places a missing value at whatever follows it.
    if (!open_.empty() && open_.back().has_key && node.place.line != open_.back().key_place.line) {
      node.place = open_.back().key_place;
    }
    Finish(std::move(node), anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) {
      throw YamlFailure{PlaceOf(mark), "this alias (*) stands inside the value it names"};
    }
    const auto [node, size, depth] = found->second;
    if (static_cast<int>(open_.size()) + depth > kMaxYamlDepth) ThrowTooDeep(PlaceOf(mark));
    Count(size, PlaceOf(mark));
    Add(YamlNode(node), PlaceOf(mark));
    RaiseDepth(depth);
  }
  void OnScalar(const YAML::Mark& mark,
                const std::string& tag,
                YAML::anchor_t anchor,
                const std::string& value) override {
    CheckTag(tag, mark);
    YamlNode node;
    node.kind = YamlNode::Kind::kScalar;
    node.place = PlaceOf(mark);
    node.text = value;
    node.quoted = tag == "!";
    if (node.quoted) RefuseOpenQuote(mark);
    Finish(std::move(node), anchor);
  }
  void OnSequenceStart(const YAML::Mark& mark,
                       const std::string& tag,
                       YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    Open(YamlNode::Kind::kList, mark, tag, anchor);
  }
  void OnSequenceEnd() override { Close(); }
  void OnMapStart(const YAML::Mark& mark,
                  const std::string& tag,
                  YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    Open(YamlNode::Kind::kMap, mark, tag, anchor);
  }
  void OnMapEnd() override { Close(); }

  /// Where the innermost list or map that is not finished began.
  [[nodiscard]] std::optional<Place> InnermostOpen(YamlNode::Kind kind) const {
    for (auto open = open_.rbegin(); open != open_.rend(); ++open) {
      if (open->node.kind == kind) return open->node.place;
    }
    return std::nullopt;
  }

  [[nodiscard]] bool finished() const { return finished_; }
  YamlNode& root() { return root_; }
  std::vector<Problem>& problems() { return problems_; }

 private:
  struct OpenNode {
    YamlNode node;
    YAML::anchor_t anchor = YAML::NullAnchor;
    int first_node = 0;  // value of num_nodes_ when it was opened
    int depth = 1;       // levels below and including this one
    bool has_key = false;
    bool skip_value = false;  // the key was refused
    std::string key;
    Place key_place;
  };
  struct Anchored {
    YamlNode node;
    int size = 1;
    int depth = 1;
  };

  [[noreturn]] static void ThrowTooDeep(const Place& place) {
    throw YamlFailure{
        place, "values are nested more than " + std::to_string(kMaxYamlDepth) + " levels deep"};
  }

  void Count(int more, const Place& place) {
    num_nodes_ += more;
    if (num_nodes_ > kMaxYamlNodes) {
      throw YamlFailure{
          place, "more than " + std::to_string(kMaxYamlNodes) + " values (aliases written out)"};
    }
  }

  void CheckTag(const std::string& tag, const YAML::Mark& mark) {
    if (!tag.empty() && tag != "?" && tag != "!") {
      problems_.push_back({PlaceOf(mark), "", "tags ('!…') are not supported; remove it"});
    }
  }

  // The parser takes the end of the file for a closing quote.
  void RefuseOpenQuote(const YAML::Mark& mark) const {
    const std::size_t begin = text_.find_first_of("\"'", static_cast<std::size_t>(mark.pos));
    if (begin == std::string::npos) return;
    for (std::size_t i = begin + 1; i < text_.size(); ++i) {
      const bool pair = text_[begin] == '"' ? text_[i] == '\\' : text_.compare(i, 2, "''") == 0;
      if (pair) {
        ++i;
      } else if (text_[i] == text_[begin]) {
        return;
      }
    }
    throw YamlFailure{PlaceOf(mark), "this quote is never closed"};
  }

  void RaiseDepth(int depth_below) {
    if (!open_.empty()) open_.back().depth = std::max(open_.back().depth, depth_below + 1);
  }

  void Open(YamlNode::Kind kind,
            const YAML::Mark& mark,
            const std::string& tag,
            YAML::anchor_t anchor) {
    CheckTag(tag, mark);
    if (static_cast<int>(open_.size()) >= kMaxYamlDepth) ThrowTooDeep(PlaceOf(mark));
    OpenNode open;
    open.node.kind = kind;
    open.node.place = PlaceOf(mark);
    open.anchor = anchor;
    open.first_node = num_nodes_;
    open_.push_back(std::move(open));
  }

  void Close() {
    OpenNode open = std::move(open_.back());
    open_.pop_back();
    Count(1, open.node.place);
    const Place place = open.node.place;
    if (open.anchor != YAML::NullAnchor) {
      anchors_[open.anchor] = {open.node, num_nodes_ - open.first_node, open.depth};
    }
    Add(std::move(open.node), place);
    RaiseDepth(open.depth);
  }

  void Finish(YamlNode node, YAML::anchor_t anchor) {
    Count(1, node.place);
    if (anchor != YAML::NullAnchor) anchors_[anchor] = {node, 1, 1};
    const Place place = node.place;
    Add(std::move(node), place);
    RaiseDepth(1);
  }

  // Puts a finished node into the innermost open one: as a key, a value or an item.
  void Add(YamlNode node, const Place& place) {
    if (open_.empty()) {
      root_ = std::move(node);
      return;
    }
    OpenNode& parent = open_.back();
    if (parent.node.IsList()) {
      parent.node.items.push_back(std::move(node));
    } else if (!parent.has_key) {
      AddKey(parent, node, place);
    } else {
      if (!parent.skip_value) {
        parent.node.entries.push_back({parent.key, parent.key_place, std::move(node)});
      }
      parent.has_key = false;
    }
  }

  void AddKey(OpenNode& parent, const YamlNode& node, const Place& place) {
    parent.has_key = true;
    parent.skip_value = true;
    parent.key_place = place;
    parent.key = node.text;
    if (node.kind == YamlNode::Kind::kNull) {
      problems_.push_back({place, "", "a key is missing here"});
    } else if (!node.IsScalar()) {
      problems_.push_back({place, "", "a key must be text, not " + DescribeNode(node)});
    } else if (parent.key == "<<" && !node.quoted) {
      problems_.push_back(
          {place, "", "merge keys (<<) are not supported; write the keys out, or alias one value"});
    } else {
      const auto& entries = parent.node.entries;
      const auto first = std::ranges::find_if(
          entries, [&](const YamlEntry& entry) { return entry.key == parent.key; });
      parent.skip_value = first != entries.end();
      if (parent.skip_value) {
        problems_.push_back({place,
                             "",
                             "key '" + parent.key + "' is given twice (first at " +
                                 std::to_string(first->key_place.line) + ":" +
                                 std::to_string(first->key_place.column) + ")"});
      }
    }
  }

  const std::string& text_;
  YamlNode root_;
  std::vector<OpenNode> open_;
  std::map<YAML::anchor_t, Anchored> anchors_;
  std::vector<Problem> problems_;
  int num_nodes_ = 0;
  bool finished_ = false;
};

constexpr const char* kOpenList = "this '[' is never closed by ']'";
constexpr const char* kOpenMap = "this '{' is never closed by '}'";

// The parser's texts in the words of somebody who writes a config.
std::string Explain(const std::string& parser_text) {
  constexpr std::array<std::pair<const char*, const char*>, 14> kTexts = {{
      {"illegal map value", "':' is not expected here; check the indentation, or quote the text"},
      {"illegal map key", "a key is not expected here; check the indentation"},
      {"illegal block entry", "'-' is not expected here; check the indentation"},
      {"end of sequence flow", kOpenList},
      {"end of map flow", kOpenMap},
      {"illegal flow end", "this closing bracket has no opening one"},
      {"end of sequence", "this list ends in the wrong column; check the indentation"},
      {"end of map", "this map ends in the wrong column; check the indentation"},
      {"EOF in scalar", "a quote is never closed"},
      {"document indicator in scalar", "a quote is never closed"},
      {"anchor is not defined", "this alias (*) names no anchor (&) written before it"},
      {"unknown token", "this character cannot start a value; quote the text"},
      {"escape character", "unknown escape after '\\' in double quotes; use single quotes"},
      {"bad dereference", "a value is missing here"},
  }};
  for (const auto& [part, text] : kTexts) {
    if (parser_text.find(part) != std::string::npos) return text;
  }
  return "this is not valid YAML; check brackets, quotes and indentation";
}

// Fills root and problems, or throws YamlFailure.
void ParseInto(const std::string& text, YamlDocument& document) {
  RefuseBinary(text);
  document.source.lines = SplitLines(text);
  RefuseTabs(document.source.lines);
  std::istringstream stream(text);
  TreeBuilder builder(text);
  try {
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    document.problems = std::move(builder.problems());
    const std::string explanation = Explain(error.msg);
    Place place = PlaceOf(error.mark);
    // Of a bracket that stays open, the parser names what comes instead of its end.
    if (explanation == kOpenList || explanation == kOpenMap) {
      const bool is_map = explanation == kOpenMap;
      const Place open =
          builder.InnermostOpen(is_map ? YamlNode::Kind::kMap : YamlNode::Kind::kList)
              .value_or(place);
      const bool at_end = text.find_first_not_of(" \n", static_cast<std::size_t>(error.mark.pos)) ==
                          std::string::npos;
      if (open.line == place.line && !at_end) {
        const char* close = is_map ? "'}'" : "']'";
        throw YamlFailure{
            place, std::string("',' or ") + close + " is needed before this (is a comma missing?)"};
      }
      place = open;
    }
    throw YamlFailure{place, explanation};
  }
  document.problems = std::move(builder.problems());
  if (!builder.finished()) throw YamlFailure{{}, "the config is empty"};
  document.root = std::move(builder.root());
}

[[noreturn]] void Throw(const YamlDocument& document, const YamlFailure& failure) {
  std::vector<Problem> problems = document.problems;
  problems.push_back({failure.place, "", failure.text});
  throw ConfigError(document.source, problems);
}

void SetPlaces(YamlNode& node, const Place& place) {
  node.place = place;
  for (YamlNode& item : node.items) SetPlaces(item, place);
  for (YamlEntry& entry : node.entries) {
    entry.key_place = place;
    SetPlaces(entry.value, place);
  }
}

}  // namespace

YamlDocument LoadYamlFile(const std::filesystem::path& path) {
  YamlDocument document;
  document.source.file = path.string();
  std::error_code status;
  if (std::filesystem::is_directory(path, status)) {
    Throw(document, {{}, "this is a directory; a config file is needed"});
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) Throw(document, {{}, "the config cannot be opened (is the name right?)"});
  std::string text;
  constexpr std::size_t kChunk = 65536;
  std::string chunk(kChunk, '\0');
  while (file.read(chunk.data(), static_cast<std::streamsize>(kChunk)) || file.gcount() > 0) {
    text.append(chunk, 0, static_cast<std::size_t>(file.gcount()));
    if (text.size() > kMaxFileBytes) Throw(document, {{}, "the config is larger than 16 MiB"});
  }
  if (file.bad()) Throw(document, {{}, "the config cannot be read"});
  return ParseYaml(text, path.string());
}

YamlDocument ParseYaml(const std::string& text, const std::string& file) {
  YamlDocument document;
  document.source.file = file;
  document.text = text;
  constexpr const char* kByteOrderMark = "\xEF\xBB\xBF";
  const bool has_mark = text.rfind(kByteOrderMark, 0) == 0;
  try {
    ParseInto(has_mark ? text.substr(3) : text, document);
  } catch (const YamlFailure& failure) {
    Throw(document, failure);
  }
  return document;
}

YamlNode ParseOverrideValue(const std::string& text,
                            const Place& place,
                            const std::string& path,
                            std::vector<Problem>& problems) {
  YamlDocument document;
  try {
    ParseInto(text, document);
  } catch (const YamlFailure& failure) {
    document.problems.push_back({place, path, failure.text});
    if (text.find_first_not_of(' ') == std::string::npos) {
      document.problems.back().text = "no value after '='";
    }
  }
  for (const Problem& problem : document.problems) problems.push_back({place, path, problem.text});
  SetPlaces(document.root, place);
  return document.problems.empty() ? document.root : YamlNode{};
}

}  // namespace pathfit::app
