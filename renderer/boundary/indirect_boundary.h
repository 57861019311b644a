#pragma once

#include "renderer/boundary/boundary_segment.h"

namespace pathfit::renderer {

/// Indirect boundary: edges between two surfaces, seen through reflected light. A tangent direction
/// of an edge gives the segment; a path from x_S gives the radiance by the number of reflections
/// (emission at x_S belongs to the direct boundary and is left out), and detector subpaths bring it
/// to the sensor. Source: path_space 1.7 (B), 2.4; [Zhang2020].
class IndirectBoundary : public BoundaryTechnique {
 public:
  explicit IndirectBoundary(const BoundaryContext& context) : context_(context) {}

  [[nodiscard]] std::vector<BoundaryWay> Ways() const override;
  [[nodiscard]] std::int64_t NumSamples() const override;
  void Sample(std::size_t way, const BoundaryDraw& draw, SplatBuffer& splats) const override;

 private:
  const BoundaryContext& context_;
};

}  // namespace pathfit::renderer
