#pragma once

#include <cmath>

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// Right-handed orthonormal frame around a unit normal.
struct Frame {
  Vec3 s, t, n;

  /// [Duff et al. 2017, Building an Orthonormal Basis, Revisited]
  static Frame FromNormal(const Vec3& n) {
    const double sign = std::copysign(1.0, n.z);
    const double a = -1.0 / (sign + n.z);
    const double b = n.x * n.y * a;
    return {
        {1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
  }
  [[nodiscard]] Vec3 ToWorld(const Vec3& v) const { return s * v.x + t * v.y + n * v.z; }
  [[nodiscard]] Vec3 ToLocal(const Vec3& v) const { return {Dot(s, v), Dot(t, v), Dot(n, v)}; }
};

}  // namespace pathfit::renderer
