#pragma once

#include <cmath>
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
  /// side of the plane of edge and line. Borders always are, except in their own plane. A face that
  /// the line grazes counts as turned away from w: of the two edges that such a face has, one is a
  /// silhouette, whatever rounding says.
  [[nodiscard]] bool IsSilhouette(const Vec3& w) const {
    return (Dot(n0, w) > kGrazing) != (Dot(n1, w) > kGrazing);
  }
  /// Whether the line lies in the plane of one of its faces.
  [[nodiscard]] bool Grazes(const Vec3& w) const {
    return std::abs(Dot(n0, w)) <= kGrazing || std::abs(Dot(n1, w)) <= kGrazing;
  }
  static constexpr double kGrazing = 1e-12;  ///< cosine
  [[nodiscard]] double Length() const { return Norm(b - a); }
};

}  // namespace pathfit::renderer
