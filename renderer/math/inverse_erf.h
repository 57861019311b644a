#pragma once

#include <cmath>
#include <numbers>

namespace pathfit::renderer {

/// Inverse of the error function to about 2e-3, from 1 - its value, in (0, 1]: a start for Newton's
/// method. Infinite for 0. Source: [Winitzki2008].
inline double RoughInverseErf(double complement) {
  constexpr double kShape = 0.147;
  const double log = std::log(complement * (2.0 - complement));
  const double middle = 2.0 / (std::numbers::pi * kShape) + 0.5 * log;
  return std::sqrt(std::sqrt(middle * middle - log / kShape) - middle);
}

}  // namespace pathfit::renderer
