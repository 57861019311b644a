#pragma once

#include <algorithm>
#include <limits>

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// Axis-aligned. It holds nothing until something is included: then low > high.
struct Box {
  Vec3 low = Vec3{1, 1, 1} * std::numeric_limits<double>::infinity();
  Vec3 high = -low;

  void Include(const Vec3& x) {
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], x[i]);
      high[i] = std::max(high[i], x[i]);
    }
  }
  void Include(const Box& other) {
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], other.low[i]);
      high[i] = std::max(high[i], other.high[i]);
    }
  }
  [[nodiscard]] bool Meets(const Box& other) const {
    return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y &&
           other.low.y <= high.y && low.z <= other.high.z && other.low.z <= high.z;
  }
  /// To the nearest point of the box.
  [[nodiscard]] double Distance(const Vec3& x) const {
    Vec3 away;
    for (int i = 0; i < 3; ++i) {
      away[i] = std::max({0.0, low[i] - x[i], x[i] - high[i]});
    }
    return Norm(away);
  }
  /// Whether a half-line comes within `margin` > 0 of the box along each axis.
  [[nodiscard]] bool MayMeet(const Vec3& origin, const Vec3& direction, double margin) const {
    double near = 0.0;
    double far = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
      const double inverse = 1.0 / direction[i];
      const double to_low = (low[i] - margin - origin[i]) * inverse;
      const double to_high = (high[i] + margin - origin[i]) * inverse;
      near = std::max(near, std::min(to_low, to_high));
      far = std::min(far, std::max(to_low, to_high));
    }
    return near <= far;
  }
  [[nodiscard]] Vec3 Middle() const { return (low + high) * 0.5; }
  [[nodiscard]] Vec3 Size() const { return high - low; }
  [[nodiscard]] double HalfDiagonal() const { return 0.5 * Norm(Size()); }
  /// 0, 1 or 2.
  [[nodiscard]] int LongestAxis() const {
    const Vec3 size = Size();
    return size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
  }
};

template <class Points>
Box BoxAround(const Points& points) {
  Box box;
  for (const Vec3& x : points) {
    box.Include(x);
  }
  return box;
}

}  // namespace pathfit::renderer
