#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// Refuses steps that would wreck a moving mesh: a coordinate that is not finite, a triangle of no
/// area, more than a small share of triangles that turn over or shrink below kCollapsed of their
/// area before the round, of edges that fold (renderer::AreFolded), or of triangles that begin to
/// pass through others.
class VertexGuard {
 public:
  /// `values`: the round's start, in units of the scene.
  VertexGuard(const renderer::Scene& scene,
              const ParameterSet& set,
              const std::vector<double>& values);

  [[nodiscard]] bool Admits(const std::vector<double>& values) const;

  static constexpr double kCollapsed = 1e-3;
  static constexpr double kAllowedShare = 0.005;

 private:
  struct Surface {
    std::size_t offset;                                 ///< of the first vertex in the values
    renderer::Mesh mesh;                                ///< of which only the triangles count
    std::vector<std::array<std::size_t, 2>> neighbors;  ///< triangles that are not folded now
    std::size_t crossing = 0;                           ///< triangles that pass through others now
    std::vector<renderer::Vec3> area_vectors;           ///< twice the area times the normal
  };
  std::vector<Surface> surfaces_;
};

}  // namespace pathfit::optim
