#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "renderer/geometry/near_corner.h"

namespace pathfit::renderer {

/// How near points of one mesh are to concave corners of the same mesh: RayCaster::Nearness with
/// this mesh only, over a tree whose bounds know which way its surfaces face, so that the flat
/// surroundings of a point need not be visited. The tree is made when it is asked for first.
/// Thread-safe.
class OwnCorners {
 public:
  /// `triangles`: all of the mesh; they must outlive the result.
  explicit OwnCorners(std::span<const TriangleGeometry> triangles) : triangles_(triangles) {}

  /// Before the surface that view.n points away from; at most `most`, at most 1.
  [[nodiscard]] double Nearness(const CornerView& view,
                                double reach,
                                double most = 1.0,
                                NearFacts* facts = nullptr) const;

 private:
  /// Of triangles order_[first .. first + count); inner if right > 0, with its left child behind
  /// it. Their corners lie in a sphere about `center` and within `thickness` of the plane through
  /// it with `normal`.
  struct Node {
    Vec3 center, normal;
    double radius = 0.0, thickness = 0.0;
    std::int32_t first = 0, count = 0;
    std::int32_t right = 0;
  };
  struct Tree {
    std::vector<std::int32_t> order;
    std::vector<Node> nodes;
  };
  class Builder;

  std::span<const TriangleGeometry> triangles_;
  mutable std::once_flag tree_made_;
  mutable Tree tree_;
};

}  // namespace pathfit::renderer
