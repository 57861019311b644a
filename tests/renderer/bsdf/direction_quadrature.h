#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "renderer/math/vector.h"

namespace pathfit::tests {

inline renderer::Vec3 DirectionAt(double cos_theta, double phi) {
  const double s = std::sqrt(std::max(0.0, 1.0 - cos_theta * cos_theta));
  return {s * std::cos(phi), s * std::sin(phi), cos_theta};
}

/// Integral of f(direction) over the hemisphere around +z: composite four-point Gauss-Legendre in
/// the polar angle, trapezoid rule in azimuth (exponentially accurate for what is periodic).
template <class F>
double HemisphereIntegral(int panels, int azimuths, F f) {
  constexpr std::array<double, 4> kNodes = {
      -0.861136311594052575, -0.339981043584856265, 0.339981043584856265, 0.861136311594052575};
  constexpr std::array<double, 4> kWeights = {
      0.347854845137453857, 0.652145154862546143, 0.652145154862546143, 0.347854845137453857};
  const double width = 0.5 * std::numbers::pi / panels;
  double sum = 0.0;
  for (int panel = 0; panel < panels; ++panel) {
    for (std::size_t k = 0; k < kNodes.size(); ++k) {
      const double theta = width * (panel + 0.5 + 0.5 * kNodes[k]);
      double ring = 0.0;
      for (int j = 0; j < azimuths; ++j) {
        ring += f(DirectionAt(std::cos(theta), 2.0 * std::numbers::pi * (j + 0.5) / azimuths));
      }
      sum += 0.5 * width * kWeights[k] * std::sin(theta) * ring;
    }
  }
  return sum * 2.0 * std::numbers::pi / azimuths;
}

}  // namespace pathfit::tests
