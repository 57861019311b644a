#pragma once

#include <algorithm>

#include "renderer/geometry/triangle_kernel.h"

namespace pathfit::renderer {

/// The point of the segment a..b next to x.
inline Vec3 ClosestPointOfSegment(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  return a + along * std::clamp(Dot(x - a, along) / SquaredNorm(along), 0.0, 1.0);
}

/// The point of a triangle next to x: the foot of the perpendicular where it lies inside, else a
/// point of the nearest side.
inline Vec3 ClosestPointOfTriangle(const Vec3& x, const TriangleGeometry& t) {
  const PlaneHit foot = IntersectPlane(t, x, t.n);
  if (foot.b1 >= 0.0 && foot.b2 >= 0.0 && foot.b1 + foot.b2 <= 1.0) {
    return x + t.n * foot.distance;
  }
  const Vec3 p1 = t.p0 + t.e1;
  const Vec3 p2 = t.p0 + t.e2;
  Vec3 best = ClosestPointOfSegment(x, t.p0, p1);
  for (const Vec3& y : {ClosestPointOfSegment(x, p1, p2), ClosestPointOfSegment(x, p2, t.p0)}) {
    best = SquaredNorm(y - x) < SquaredNorm(best - x) ? y : best;
  }
  return best;
}

}  // namespace pathfit::renderer
