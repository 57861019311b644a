#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "renderer/geometry/triangle_kernel.h"

namespace pathfit::renderer {

/// A triangle among those of which some may come near each other.
struct NearItem {
  const TriangleGeometry* triangle = nullptr;
  double slack = 0.0;       ///< reach around it, metres
  std::int32_t label = -1;  ///< two of one label do not count; -1: counts with all
};

/// Calls visit(i, j), i != j, once for each pair of items that may be nearer than the sum of their
/// slacks: by bounding boxes, and by the plane of one where the other stands among many. Space is
/// divided only where boxes meet: what is apart, or of one label, costs next to nothing. The order
/// is a function of the items.
void ForEachNearPair(const std::vector<NearItem>& items,
                     const std::function<void(std::size_t, std::size_t)>& visit);

/// The shares of the way along a segment between two of them.
struct SegmentPart {
  double begin = 0.0, end = 1.0;

  /// Keeps where what changes linearly along the segment, from one value to the other, is not
  /// negative.
  void Keep(double at_start, double at_finish);
  /// Keeps where the segment a..b is no farther than `slack` from a triangle; at its corners a
  /// little farther.
  void KeepNear(const TriangleGeometry& triangle, const Vec3& a, const Vec3& b, double slack);
  [[nodiscard]] bool IsEmpty() const { return !(begin <= end); }
};

}  // namespace pathfit::renderer
