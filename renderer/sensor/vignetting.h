#pragma once

#include <cmath>

namespace pathfit::renderer {

/// How a lens darkens its picture away from the principal point: a pixel's colour times exp(v1 r2 +
/// v2 r2^2 + v3 r2^3), the even powers of [Goldman2010, eq. 4] in the exponent, so that no numbers
/// leave a pixel without light. r2 is the squared distance of the pixel's centre from the principal
/// point, 1 where the corners are if that is the middle of the image (Camera::VignettingRadius2).
struct Vignetting {
  double v1 = 0.0, v2 = 0.0, v3 = 0.0;
  [[nodiscard]] bool IsNone() const { return v1 == 0.0 && v2 == 0.0 && v3 == 0.0; }
  [[nodiscard]] double LogAt(double r2) const { return r2 * (v1 + r2 * (v2 + r2 * v3)); }
  [[nodiscard]] double At(double r2) const { return std::exp(LogAt(r2)); }
  /// Derivative of LogAt by r2.
  [[nodiscard]] double LogSlope(double r2) const { return v1 + r2 * (2.0 * v2 + 3.0 * r2 * v3); }
  friend bool operator==(const Vignetting&, const Vignetting&) = default;
};

}  // namespace pathfit::renderer
