#pragma once

#include <array>
#include <optional>

#include "renderer/boundary/view_edges.h"

namespace pathfit::renderer {

/// Estimator of the primary boundary integral: mesh edges seen by the sensor sweep over pixels.
///
/// With the edge's image u(t), dI = integral over t of H (L_minus - L_plus) (m . u') dt, where m =
/// perp(du/dt) points to the plus side. In image form u' is the image velocity of the edge point.
/// In material form the edge's own faces end at a line fixed on them and count nothing; what is
/// behind the edge counts with the velocity of the edge relative to it. Right for any smooth
/// projection, distortion included. Coverage, which has no interior derivative, is in image form
/// always. Source: path_space 1.5, 1.9, eq. (B1); [Zhang2020, primary boundary].
class PrimaryBoundary : public BoundaryTechnique {
 public:
  explicit PrimaryBoundary(const BoundaryContext& context) : context_(context), edges_(context) {}

  /// One: a number along all edges.
  [[nodiscard]] std::vector<BoundaryWay> Ways() const override;
  /// The budget counts samples per pixel of weighted edge length.
  [[nodiscard]] std::int64_t NumSamples() const override;
  void Sample(std::size_t way, const BoundaryDraw& draw, SplatBuffer& splats) const override;

 private:
  struct EdgePoint;
  struct Side;
  /// The point on an edge that is drawn; empty if no pixel's filter covers it.
  [[nodiscard]] std::optional<EdgePoint> PointAt(const BoundaryDraw& draw) const;
  /// What is seen on the minus and on the plus side.
  [[nodiscard]] std::array<Side, 2> FacesBySide(const EdgePoint& point) const;
  /// Radiance of a face at the edge point.
  [[nodiscard]] Rgb ShadeFace(const EdgePoint& point, TriangleId face) const;
  /// Radiance of what lies behind the edge; `side` is +1 where the plus side sees it, -1 for the
  /// minus side.
  [[nodiscard]] Rgb ShadeBackground(const EdgePoint& point,
                                    const std::optional<Hit>& hit,
                                    double side) const;

  const BoundaryContext& context_;
  ViewEdges edges_;
};

}  // namespace pathfit::renderer
