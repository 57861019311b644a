#pragma once

#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

namespace pathfit::app {

/// The words of a text in lines of at most `width` bytes, but for single words that are longer.
inline std::vector<std::string> WrappedWords(const std::string& text, std::size_t width) {
  std::vector<std::string> lines;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (lines.empty() || lines.back().size() + 1 + word.size() > width) {
      lines.push_back(word);
    } else {
      lines.back() += " " + word;
    }
  }
  return lines;
}

}  // namespace pathfit::app
