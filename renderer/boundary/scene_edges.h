#pragma once

#include <vector>

#include "renderer/boundary/edge_tree.h"
#include "renderer/derivative/active_parameters.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/scene/scene.h"

namespace pathfit::renderer {

/// All edges of a placed scene that can hide one point from another, weighted by whether they
/// move. Left out: diagonals between coplanar faces, and concave edges of closed opaque meshes
/// whose box the viewer is outside of (nothing that lights the picture may be inside them either).
/// Edges that rest keep a small weight: what lies before or behind them may move.
std::vector<BoundaryEdge> SceneEdges(const Scene& placed,
                                     const std::vector<MeshTopology>& topologies,
                                     const ActiveParameters& active,
                                     const Vec3& viewer);

}  // namespace pathfit::renderer
