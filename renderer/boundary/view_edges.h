#pragma once

#include <vector>

#include "renderer/boundary/boundary_technique.h"
#include "renderer/math/distribution_1d.h"

namespace pathfit::renderer {

/// A mesh edge that may be a discontinuity of the image: clipped to the field of view.
struct ViewEdge {
  int mesh = 0;
  std::int32_t edge = 0;      ///< into MeshTopology::edges
  double t0 = 0.0, t1 = 1.0;  ///< visible part, as parameter between its two vertices
  double depth_ratio = 1.0;   ///< depth at t0 over depth at t1; 1 for parallel rays

  /// Parameter of the point at share `s` of the visible part's image (distortion left aside), and
  /// its derivative by s.
  struct Point {
    double t, dt;
  };
  [[nodiscard]] Point At(double s) const {
    const double scale = 1.0 / (1.0 - s + s * depth_ratio);
    return {t0 + (t1 - t0) * s * depth_ratio * scale, (t1 - t0) * depth_ratio * scale * scale};
  }
};

/// Distribution over the edges whose motion changes a sensor's image: outlines (silhouettes and
/// borders) and in image form all edges at which the radiance jumps (creases of flat shading, seams
/// of vertex colours, normals and texture coordinates). Edges are weighted by projected length in
/// pixels times an estimate of how much the radiance can jump (kMinJump for a nearly flat crease, 1
/// for an outline).
///
/// Image form: edges of what moves in the image, all if the camera does. Material form: outlines of
/// all meshes, since a resting edge bounds a background that moves. Edges that only the inside of a
/// closed, outward wound mesh sees are left out while the viewer is outside its bounding box.
/// Source: path_space 1.5, 2.2.
class ViewEdges {
 public:
  explicit ViewEdges(const BoundaryContext& context);

  [[nodiscard]] const Distribution1D& distribution() const { return distribution_; }
  [[nodiscard]] const ViewEdge& edge(int i) const { return edges_[static_cast<std::size_t>(i)]; }
  /// Whether the side of a triangle from its corner `corner` on is one of the edges.
  [[nodiscard]] bool Contains(TriangleId id, int corner) const {
    const std::vector<std::uint8_t>& sides = sides_[static_cast<std::size_t>(id.mesh)];
    return !sides.empty() && (sides[static_cast<std::size_t>(id.triangle)] >> corner & 1U) != 0;
  }

  static constexpr double kMinJump = 0.05;

 private:
  std::vector<ViewEdge> edges_;
  std::vector<std::vector<std::uint8_t>> sides_;  // by mesh and triangle: bits of Contains
  Distribution1D distribution_;
};

}  // namespace pathfit::renderer
