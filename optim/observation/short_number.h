#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace pathfit::optim {

/// For messages: four digits.
inline std::string ShortNumber(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return text.data();
}

}  // namespace pathfit::optim
