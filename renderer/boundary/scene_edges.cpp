#include "renderer/boundary/scene_edges.h"

#include <algorithm>
#include <cmath>

namespace pathfit::renderer {
namespace {

// Faces whose normals differ by less than this are one plane.
constexpr double kCoplanar = 1e-7;
// Share of the samples of an edge that rests, while other things move.
constexpr double kRestingWeight = 0.2;

bool IsOutsideBox(const Mesh& mesh, const Vec3& x) {
  for (int i = 0; i < 3; ++i) {
    const auto below = [&](const Vec3& p) { return p[i] < x[i]; };
    if (std::all_of(mesh.positions.begin(), mesh.positions.end(), below) ||
        std::none_of(mesh.positions.begin(), mesh.positions.end(), below)) {
      return true;
    }
  }
  return false;
}

/// Whether no path from the viewer can run inside the mesh: it is closed, opaque, turned outward,
/// and the viewer is outside its box.
bool IsOpaqueSolid(const Scene& scene,
                   std::size_t index,
                   const MeshTopology& topology,
                   const Vec3& viewer) {
  const SceneMesh& mesh = scene.meshes[index];
  return topology.solid && IsOutsideBox(mesh.mesh, viewer) &&
         !IsTransmissive(scene.materials[static_cast<std::size_t>(mesh.material)].bsdf);
}

Vec3 FaceNormal(const Mesh& mesh, std::int32_t face) {
  const Triangle& t = mesh.triangles[static_cast<std::size_t>(face)];
  const auto p = [&](std::size_t i) { return mesh.positions[static_cast<std::size_t>(t[i])]; };
  return Normalized(Cross(p(1) - p(0), p(2) - p(0)));
}

}  // namespace

EdgeSelection SelectEdges(const Scene& placed,
                          const std::vector<MeshTopology>& topologies,
                          const ActiveParameters& active,
                          const Vec3& viewer) {
  EdgeSelection selection;
  for (std::size_t m = 0; m < placed.meshes.size(); ++m) {
    selection.moves.push_back(active.meshes[m].moves);
    selection.solid.push_back(IsOpaqueSolid(placed, m, topologies[m], viewer));
  }
  return selection;
}

std::vector<BoundaryEdge> SceneEdges(const Scene& placed,
                                     const std::vector<MeshTopology>& topologies,
                                     const EdgeSelection& selection) {
  std::vector<BoundaryEdge> edges;
  for (std::size_t m = 0; m < placed.meshes.size(); ++m) {
    const Mesh& mesh = placed.meshes[m].mesh;
    for (std::size_t e = 0; e < topologies[m].edges.size(); ++e) {
      const MeshEdge& edge = topologies[m].edges[e];
      BoundaryEdge out;
      out.mesh = static_cast<int>(m);
      out.edge = static_cast<std::int32_t>(e);
      out.a = mesh.positions[static_cast<std::size_t>(edge.vertices[0])];
      out.b = mesh.positions[static_cast<std::size_t>(edge.vertices[1])];
      out.n0 = FaceNormal(mesh, edge.faces[0]);
      out.border = edge.faces[1] < 0;
      out.n1 = out.border ? -out.n0 : FaceNormal(mesh, edge.faces[1]);
      out.weight = selection.moves[m] ? 1.0 : kRestingWeight;
      if (!out.border) {
        if (Norm(out.n0 - out.n1) < kCoplanar) {
          continue;
        }
        const Vec3& apex = mesh.positions[static_cast<std::size_t>(edge.apex[1])];
        if (selection.solid[m] && Dot(out.n0, apex - out.a) > 0.0) {
          continue;  // concave
        }
      }
      edges.push_back(out);
    }
  }
  return edges;
}

std::shared_ptr<const EdgeTree> EdgeTreeCache::Get(const Scene& placed,
                                                   const std::vector<MeshTopology>& topologies,
                                                   const EdgeSelection& selection) {
  {
    const std::lock_guard lock(mutex_);
    if (tree_ != nullptr && selection == selection_) {
      return tree_;
    }
  }
  // Building runs in parallel, which a held lock could stop for ever.
  auto tree = std::make_shared<const EdgeTree>(SceneEdges(placed, topologies, selection));
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
