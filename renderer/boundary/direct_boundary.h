#pragma once

#include <variant>
#include <vector>

#include "renderer/boundary/boundary_segment.h"

namespace pathfit::renderer {

/// Direct boundary: edges between a light and a surface; moving shadow edges, soft and hard.
///
/// Several ways to draw the segment, each a map of three uniform numbers: a point on an area light
/// or a direction to the environment, then an edge that can be a silhouette from there; a tangent
/// direction of an edge; for point and directional lights only the edge is free. Ways that find the
/// same segments share them by the power heuristic over their unguided densities, with the
/// densities of edges replaced by their means (any weights that add up to one are right). Source:
/// path_space 1.7 (B), (K), 1.8, 2.3; for lights without extent the integral over x_S is dropped
/// like that over x_D in (B0).
class DirectBoundary : public BoundaryTechnique {
 public:
  explicit DirectBoundary(const BoundaryContext& context);

  [[nodiscard]] std::vector<BoundaryWay> Ways() const override;
  [[nodiscard]] std::int64_t NumSamples() const override;
  void Sample(std::size_t way, const BoundaryDraw& draw, SplatBuffer& splats) const override;

 private:
  struct AreaWay {};   ///< a point on an area light first, then an edge
  struct WedgeWay {};  ///< an edge first, then one of its tangent directions
  /// Or one light first, then an edge.
  using Way = std::variant<AreaWay,
                           WedgeWay,
                           const LightSet::Environment*,
                           const LightSet::PointLight*,
                           const LightSet::Directional*>;

  /// `see(x_b)`: the light as seen from an edge point.
  template <class See>
  void SampleLightFirst(const BoundaryDraw& draw,
                        const EdgeTree::Pick& pick,
                        See see,
                        SplatBuffer& splats) const;
  void SampleWedgeFirst(const BoundaryDraw& draw, SplatBuffer& splats) const;
  /// Whether something lies between x_B and the segment's source.
  [[nodiscard]] bool IsHidden(const BoundarySegment& segment) const;
  /// Share of the light-first way in a segment whose light density per steradian is `pdf`.
  [[nodiscard]] double LightShare(double pdf) const;

  const BoundaryContext& context_;
  std::vector<Way> ways_;
  double wedge_density_ = 0.0;      // of the wedge way, per metre and steradian
  double silhouette_length_ = 0.0;  // expected, seen from a random direction
};

}  // namespace pathfit::renderer
