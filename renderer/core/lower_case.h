#pragma once

#include <string>

namespace pathfit::renderer {

/// ASCII letters in lower case, other bytes as they are, in any locale: for endings of file names.
inline std::string LowerCase(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

}  // namespace pathfit::renderer
