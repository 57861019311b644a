#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "renderer/geometry/edge_tree.h"
#include "renderer/math/vector.h"

namespace pathfit::renderer {

class World;

/// Faces whose normals differ by less than this are one plane: no silhouette, no crease.
inline constexpr double kCoplanar = 1e-7;
/// Share of the samples of an edge that rests, while other things move.
inline constexpr double kRestingWeight = 0.2;

/// What decides which edges of a world count, and how much: by mesh.
struct EdgeSelection {
  std::vector<bool> moves;
  std::vector<bool> solid;  ///< closed, opaque, turned outward, and the viewer is outside its box
  bool operator==(const EdgeSelection&) const = default;
};
EdgeSelection SelectEdges(const World& world, const std::vector<bool>& moves, const Vec3& viewer);

/// All edges of a world that can hide one point from another, weighted by whether they move. Left
/// out: diagonals between coplanar faces, and concave edges of solid meshes (nothing that lights
/// the picture may be inside them either). Edges that rest keep a small weight: what lies before or
/// behind them may move.
std::vector<BoundaryEdge> SceneEdges(const World& world, const EdgeSelection& selection);

/// The tree of a world's edges for the selection that was asked for last. May be asked from several
/// threads.
class EdgeTreeCache {
 public:
  std::shared_ptr<const EdgeTree> Get(const World& world, const EdgeSelection& selection);
  /// To be called when the meshes change.
  void Clear();

 private:
  std::mutex mutex_;
  EdgeSelection selection_;
  std::shared_ptr<const EdgeTree> tree_;
};

}  // namespace pathfit::renderer
