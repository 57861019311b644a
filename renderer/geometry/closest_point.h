#pragma once

#include <algorithm>

#include "renderer/geometry/triangle_kernel.h"

namespace pathfit::renderer {

/// Squared distance of x from the segment a..b.
inline double SquaredDistanceToSegment(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double t = std::clamp(Dot(x - a, along) / SquaredNorm(along), 0.0, 1.0);
  return SquaredNorm(x - a - along * t);
}

/// Squared distance of x from a triangle: from its plane where the foot of the perpendicular lies
/// inside, else from the nearest side.
inline double SquaredDistanceToTriangle(const Vec3& x, const TriangleGeometry& t) {
  const PlaneHit foot = IntersectPlane(t, x, t.n);
  if (foot.b1 >= 0.0 && foot.b2 >= 0.0 && foot.b1 + foot.b2 <= 1.0) {
    return foot.distance * foot.distance;
  }
  const Vec3 p1 = t.p0 + t.e1;
  const Vec3 p2 = t.p0 + t.e2;
  return std::min({SquaredDistanceToSegment(x, t.p0, p1),
                   SquaredDistanceToSegment(x, p1, p2),
                   SquaredDistanceToSegment(x, p2, t.p0)});
}

}  // namespace pathfit::renderer
