#pragma once

#include <array>

#include "renderer/boundary/boundary_segment.h"

namespace pathfit::renderer {

/// Indirect boundary: edges between two surfaces, seen through reflected light. A tangent direction
/// of an edge gives the segment; a path from x_S gives the radiance by the number of reflections
/// (emission at x_S belongs to the direct boundary and is left out), and detector subpaths bring it
/// to the sensor. Source: path_space 1.7 (B), 2.4; [Zhang2020].
class IndirectBoundary {
 public:
  explicit IndirectBoundary(const BoundaryContext& context) : context_(context) {}

  /// Whether it can contribute at all.
  [[nodiscard]] bool Exists() const {
    return context_.path.max_bounces > 1 && context_.edges.WedgeTotal() > 0.0;
  }
  /// Adds one sample drawn by three uniform numbers, divided by its unguided density, times weight.
  void Sample(const std::array<double, 3>& u,
              double weight,
              IndependentSampler& sampler,
              SplatBuffer& splats) const;

 private:
  const BoundaryContext& context_;
};

}  // namespace pathfit::renderer
