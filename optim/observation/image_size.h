#pragma once

#include <cmath>
#include <cstdio>
#include <string>

#include "renderer/core/error.h"

namespace pathfit::optim {

/// A width or height that a camera file states. Throws IoError starting with `place`, "FILE:
/// width".
inline int CheckedImageSize(double value, const std::string& place) {
  constexpr double kMaxImageSize = 100000.0;
  if (!(value >= 1.0 && value <= kMaxImageSize) || value != std::floor(value)) {
    char text[80];
    std::snprintf(text, sizeof text, " %.10g is not an image size (whole, 1 to 100000)", value);
    throw renderer::IoError(place + text);
  }
  return static_cast<int>(value);
}

}  // namespace pathfit::optim
