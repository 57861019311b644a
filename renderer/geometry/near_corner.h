#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/geometry/closest_point.h"

namespace pathfit::renderer {

// A triangle that rises less above the plane of a point, as a sine, is in it.
inline constexpr double kFlat = 1e-3;
// Nearer than so many offsets, rays from a point that start beside it miss much of a triangle.
inline constexpr double kMissed = 32.0;
// A triangle that comes so near to the plane of a point, in offsets, meets the point's surface:
// what ends above it leaves a gap, in which nothing has distance zero.
inline constexpr double kMeets = 2.0;
// Distances to bounds count up to so much farther: they are rounded.
inline constexpr double kAlmost = 1.0 + 1e-9;

/// A surface point x with normal n, for which corners are looked for.
struct CornerView {
  Vec3 x, n;
  double offset = 0.0;  ///< RayCaster::Offset of x
  /// Rounding of heights above the plane of x.
  [[nodiscard]] double Rounding() const { return kOfOffset * offset; }

 private:
  static constexpr double kOfOffset = 2.5e-4;
};

/// How near a triangle is to a point, and how steeply it rises above its plane, as a sine. No rise:
/// in or below the plane, or beyond the limit.
struct NearCorner {
  double distance = 0.0, rise = 0.0;
  bool meets = false;  ///< kMeets
};

/// What was found nearest.
struct NearFacts {
  double reach = 0.0;  ///< of its mesh; 0: nothing is near
  bool meets = false;
};

/// Whether bounds tell that what is at least so far away, and not higher than `height`, does not
/// count: its distance over its rise is not less than `limit`.
inline bool IsTooFarOrFlat(double least, double height, double limit) {
  return least > 0.0 && (least >= limit || least * least >= limit * height * kAlmost ||
                         height * kAlmost <= kFlat * least);
}

inline NearCorner CornerSeen(const CornerView& view, const TriangleGeometry& t, double limit) {
  const std::array<Vec3, 3> to_corners = {
      t.p0 - view.x, t.p0 + t.e1 - view.x, t.p0 + t.e2 - view.x};
  const auto [lowest, height] = std::minmax(
      {Dot(view.n, to_corners[0]), Dot(view.n, to_corners[1]), Dot(view.n, to_corners[2])});
  if (!(height > 0.0)) {
    return {};
  }
  // No point of a triangle is farther from its first corner than its longer side from there.
  const double side = std::sqrt(std::max(SquaredNorm(t.e1), SquaredNorm(t.e2)));
  if (IsTooFarOrFlat(Norm(to_corners[0]) / kAlmost - side, height, limit)) {
    return {};
  }
  const Vec3 to_nearest = ClosestPointOfTriangle(view.x, t) - view.x;
  NearCorner corner{Norm(to_nearest), 0.0, lowest <= kMeets * view.offset};
  if (corner.distance >= limit) {
    return {};  // a rise is at most 1
  }
  // A point's own triangle is above or below it by rounding only.
  const double least = view.Rounding();
  const auto look_at = [&](const Vec3& to) {
    const double norm = Norm(to);
    if (norm > least) {
      corner.rise = std::max(corner.rise, Dot(view.n, to) / norm);
    }
  };
  look_at(to_nearest);
  std::for_each(to_corners.begin(), to_corners.end(), look_at);
  return corner.rise > kFlat && corner.distance < limit * corner.rise ? corner : NearCorner{};
}

/// Distance over rise, which is less than the limit it was looked for with; 0 where rays no longer
/// meet the triangle as they should.
inline double NearnessOf(const CornerView& view, const NearCorner& corner) {
  const double distance = corner.distance / corner.rise;
  return distance < kMissed * view.offset ? 0.0 : distance;
}

}  // namespace pathfit::renderer
