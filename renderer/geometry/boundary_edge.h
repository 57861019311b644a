#pragma once

#include <cstdint>

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// An edge that can hide something from something: world frame.
struct BoundaryEdge {
  int mesh = 0;
  std::int32_t edge = 0;  ///< into MeshTopology::edges
  Vec3 a, b;              ///< ends, in the winding order of its first face
  Vec3 n0, n1;            ///< unit geometric normals of its faces; a border has n1 = -n0
  bool border = false;
  double weight = 1.0;  ///< importance relative to other edges, > 0 (e.g. small if it rests)

  /// Whether the edge is a silhouette for a line in direction w through it: both faces lie on one
  /// side of the plane of edge and line. Borders always are, except in their own plane.
  [[nodiscard]] bool IsSilhouette(const Vec3& w) const { return Dot(n0, w) * Dot(n1, w) < 0.0; }
  [[nodiscard]] double Length() const { return Norm(b - a); }
};

}  // namespace pathfit::renderer
