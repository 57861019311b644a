#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// Keeps steps from wrecking a moving mesh: triangles that turn over or shrink below kCollapsed of
/// their area before the round, edges that fold (renderer::AreFolded), triangles that begin to pass
/// through others.
class VertexGuard {
 public:
  /// `values`: the round's start, in units of the scene.
  VertexGuard(const renderer::Scene& scene,
              const ParameterSet& set,
              const std::vector<double>& values);

  /// Where a step makes a wreck that was none before, its vertices there go only as far as they
  /// can, and with them the more of their neighbours the longer that takes; all others keep theirs.
  /// False where that does not help, or a number is not finite.
  [[nodiscard]] bool Restrain(std::vector<double>& values) const;

  static constexpr double kCollapsed = 1e-3;

 private:
  struct Surface {
    std::size_t offset;  ///< of the first vertex in the values
    renderer::Mesh mesh;
    renderer::MeshTopology topology;
    std::vector<std::array<std::size_t, 2>> neighbors;  ///< triangles that are not folded now
    std::vector<char> crosses;                          ///< by triangle, now
    std::vector<renderer::Vec3> area_vectors;           ///< twice the area times the normal
    double mean_area = 0.0;                             ///< mean length of these
  };
  [[nodiscard]] static std::vector<char> VerticesOfWrecks(const Surface& surface,
                                                          const renderer::Mesh& moved);
  [[nodiscard]] static bool Restrain(const Surface& surface, std::vector<double>& values);

  std::vector<Surface> surfaces_;
};

}  // namespace pathfit::optim
