#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "renderer/boundary/edge_tree.h"
#include "renderer/derivative/active_parameters.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/scene/scene.h"

namespace pathfit::renderer {

/// What decides which edges of a placed scene count, and how much: by mesh.
struct EdgeSelection {
  std::vector<bool> moves;
  std::vector<bool> solid;  ///< closed, opaque, turned outward, and the viewer is outside its box
  bool operator==(const EdgeSelection&) const = default;
};
EdgeSelection SelectEdges(const Scene& placed,
                          const std::vector<MeshTopology>& topologies,
                          const ActiveParameters& active,
                          const Vec3& viewer);

/// All edges of a placed scene that can hide one point from another, weighted by whether they
/// move. Left out: diagonals between coplanar faces, and concave edges of solid meshes (nothing
/// that lights the picture may be inside them either). Edges that rest keep a small weight: what
/// lies before or behind them may move.
std::vector<BoundaryEdge> SceneEdges(const Scene& placed,
                                     const std::vector<MeshTopology>& topologies,
                                     const EdgeSelection& selection);

/// The tree of a scene's edges, kept while neither meshes nor selection change: most views of a
/// round share it. May be asked from several threads.
class EdgeTreeCache {
 public:
  std::shared_ptr<const EdgeTree> Get(const Scene& placed,
                                      const std::vector<MeshTopology>& topologies,
                                      const EdgeSelection& selection);
  /// To be called when the meshes change.
  void Clear();

 private:
  std::mutex mutex_;
  EdgeSelection selection_;
  std::shared_ptr<const EdgeTree> tree_;
};

}  // namespace pathfit::renderer
