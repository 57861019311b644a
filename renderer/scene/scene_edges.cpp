#include "renderer/scene/scene_edges.h"

#include <algorithm>
#include <cmath>

#include "renderer/geometry/mesh_checks.h"
#include "renderer/scene/world.h"

namespace pathfit::renderer {
namespace {

/// Whether no path from the viewer can run inside the mesh: it is closed, opaque, turned outward,
/// and the viewer is outside its box.
bool IsOpaqueSolid(const World& world, int mesh, const Vec3& viewer) {
  return world.topology(mesh).solid && IsOutsideBox(world.mesh(mesh), viewer) &&
         !IsTransmissive(world.MaterialOf(mesh).bsdf);
}

}  // namespace

EdgeSelection SelectEdges(const World& world, const std::vector<bool>& moves, const Vec3& viewer) {
  EdgeSelection selection{moves, {}};
  for (int m = 0; m < world.NumMeshes(); ++m) {
    selection.solid.push_back(IsOpaqueSolid(world, m, viewer));
  }
  return selection;
}

std::vector<BoundaryEdge> SceneEdges(const World& world, const EdgeSelection& selection) {
  std::vector<BoundaryEdge> edges;
  for (int m = 0; m < world.NumMeshes(); ++m) {
    const Mesh& mesh = world.mesh(m);
    const MeshTopology& topology = world.topology(m);
    std::vector<Vec3> normals;
    normals.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      normals.push_back(TriangleNormal(mesh, static_cast<std::int32_t>(t)));
    }
    const bool moves = selection.moves[static_cast<std::size_t>(m)];
    const bool solid = selection.solid[static_cast<std::size_t>(m)];
    for (std::size_t e = 0; e < topology.edges.size(); ++e) {
      const MeshEdge& edge = topology.edges[e];
      BoundaryEdge out;
      out.mesh = m;
      out.edge = static_cast<std::int32_t>(e);
      out.a = mesh.positions[static_cast<std::size_t>(edge.vertices[0])];
      out.b = mesh.positions[static_cast<std::size_t>(edge.vertices[1])];
      out.n0 = normals[static_cast<std::size_t>(edge.faces[0])];
      out.border = edge.faces[1] < 0;
      out.n1 = out.border ? -out.n0 : normals[static_cast<std::size_t>(edge.faces[1])];
      out.weight = moves ? 1.0 : kRestingWeight;
      if (!out.border) {
        if (Norm(out.n0 - out.n1) < kCoplanar) {
          continue;
        }
        const Vec3& apex = mesh.positions[static_cast<std::size_t>(edge.apex[1])];
        if (solid && Dot(out.n0, apex - out.a) > 0.0) {
          continue;  // concave
        }
      }
      edges.push_back(out);
    }
  }
  return edges;
}

std::shared_ptr<const EdgeTree> EdgeTreeCache::Get(const World& world,
                                                   const EdgeSelection& selection) {
  {
    const std::lock_guard lock(mutex_);
    if (tree_ != nullptr && selection == selection_) {
      return tree_;
    }
  }
  // Building runs in parallel, which a held lock could stop for ever.
  auto tree = std::make_shared<const EdgeTree>(SceneEdges(world, selection));
  const std::lock_guard lock(mutex_);
  tree_ = tree;
  selection_ = selection;
  return tree;
}

void EdgeTreeCache::Clear() {
  const std::lock_guard lock(mutex_);
  tree_ = nullptr;
}

}  // namespace pathfit::renderer
