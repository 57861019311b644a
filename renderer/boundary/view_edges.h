#pragma once

#include <vector>

#include "renderer/geometry/mesh_topology.h"
#include "renderer/math/distribution_1d.h"
#include "renderer/scene/scene.h"

namespace pathfit::renderer {

/// A mesh edge that may be a discontinuity of the image: clipped to the field of view.
struct ViewEdge {
  int mesh = 0;
  std::int32_t edge = 0;      ///< into MeshTopology::edges
  double t0 = 0.0, t1 = 1.0;  ///< visible part, as parameter between its two vertices
};

/// Distribution over the edges of the moving meshes at which a sensor's image can jump:
/// silhouettes, borders, creases of flat shading, seams of vertex colours. Edges are weighted by
/// projected length in pixels times an estimate of how much the radiance can jump (kMinJump for a
/// nearly flat crease, 1 for a silhouette).
class ViewEdges {
 public:
  /// `moves[m]`: whether the vertices of mesh m are parameters. `topologies` are those of the
  /// scene's meshes.
  ViewEdges(const Scene& scene,
            const std::vector<MeshTopology>& topologies,
            const std::vector<bool>& moves,
            const CameraModel& camera);

  [[nodiscard]] const Distribution1D& distribution() const { return distribution_; }
  [[nodiscard]] const ViewEdge& edge(int i) const { return edges_[static_cast<std::size_t>(i)]; }

  static constexpr double kMinJump = 0.05;

 private:
  std::vector<ViewEdge> edges_;
  Distribution1D distribution_;
};

}  // namespace pathfit::renderer
