#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "renderer/geometry/mesh.h"
#include "renderer/geometry/triangle_kernel.h"
#include "renderer/math/box.h"

namespace pathfit::renderer {

/// A point of a mesh: weights of the corners of a triangle, adding up to one.
struct ClosestPoint {
  std::int32_t triangle = -1;  ///< -1: none
  std::array<double, 3> weights{};
  Vec3 position;
};

/// Tree of bounding boxes over the triangles of a mesh, in double precision: what asks for
/// distances rather than rays. NearestSurface (surface_distance.h) takes half the time per point,
/// but two to fifty times as long to build: it pays for far more points than triangles, as when
/// results are compared; it cannot choose by normals either.
class TriangleTree {
 public:
  /// Precondition: ValidateMesh passed, but for crossing or folded triangles. Changes of the mesh
  /// afterwards do not reach the tree.
  explicit TriangleTree(const Mesh& mesh);

  /// The point of the surface next to x. With `outward` (of any length, not zero) only triangles
  /// whose normal is within a right angle of it count, so that a point beside one side of a thin
  /// wall does not find the other; if there are none, all do.
  [[nodiscard]] ClosestPoint Closest(const Vec3& x) const;
  [[nodiscard]] ClosestPoint Closest(const Vec3& x, const Vec3& outward) const;

 private:
  /// Of triangles order_[first .. first + count); inner if right > 0, with its left child behind
  /// it.
  struct Node {
    Box box;
    std::int32_t first = 0, count = 0;
    std::int32_t right = 0;
  };
  static constexpr std::size_t kMostNodesAside = 64;  // halves of at most 2^31 triangles

  std::int32_t Build(std::int32_t first, std::int32_t count, const std::vector<Vec3>& middles);
  [[nodiscard]] ClosestPoint Find(const Vec3& x, const Vec3* outward) const;

  std::vector<TriangleGeometry> triangles_;
  std::vector<Box> boxes_;  // by triangle
  std::vector<std::int32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace pathfit::renderer
