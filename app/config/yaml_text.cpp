#include "app/config/yaml_text.h"

#include <algorithm>
#include <optional>
#include <sstream>
#include <utility>

#include "app/config/utf8.h"

namespace pathfit::app {
namespace {

std::vector<std::string> Split(const std::string& text) {
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

}  // namespace

std::vector<std::string> SplitTextLines(const std::string& text) {
  RefuseBinary(text);
  std::vector<std::string> lines = Split(text);
  RefuseTabs(lines);
  return lines;
}

}  // namespace pathfit::app
