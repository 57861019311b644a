#include "renderer/geometry/mesh_topology.h"

#include <algorithm>
#include <cstddef>
#include <unordered_map>

#include "renderer/core/check.h"
#include "renderer/geometry/disjoint_sets.h"
#include "renderer/geometry/mesh_checks.h"

namespace pathfit::renderer {
namespace {

/// Whether every connected piece of a closed mesh is wound outwards.
bool IsWoundOutwards(const Mesh& mesh) {
  DisjointSets pieces(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    pieces.Unite(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]));
    pieces.Unite(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[2]));
  }
  std::vector<double> volume(mesh.positions.size(), 0.0);
  const Vec3& origin = mesh.positions.front();
  for (const Triangle& t : mesh.triangles) {
    const auto p = [&](std::size_t i) {
      return mesh.positions[static_cast<std::size_t>(t[i])] - origin;
    };
    volume[pieces.Find(static_cast<std::size_t>(t[0]))] += Dot(p(0), Cross(p(1), p(2)));
  }
  return std::none_of(volume.begin(), volume.end(), [](double v) { return v < 0.0; });
}

}  // namespace
MeshTopology MeshTopology::Build(const Mesh& mesh) {
  MeshTopology topology;
  std::unordered_map<std::uint64_t, std::size_t> edge_of;
  edge_of.reserve(mesh.triangles.size() * 2);
  // Edges stand in the order in which the triangles first mention them.
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const Triangle& triangle = mesh.triangles[f];
    const auto face = static_cast<std::int32_t>(f);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t from = triangle[k];
      const std::int32_t to = triangle[(k + 1) % 3];
      const std::int32_t apex = triangle[(k + 2) % 3];
      const auto [entry, is_new] = edge_of.try_emplace(EdgeKey(from, to), topology.edges.size());
      if (is_new) {
        topology.edges.push_back({{from, to}, {face, -1}, {apex, -1}});
        continue;
      }
      MeshEdge& edge = topology.edges[entry->second];
      PATHFIT_CHECK(edge.faces[1] == -1 && edge.vertices[0] == to);
      edge.faces[1] = face;
      edge.apex[1] = apex;
    }
  }
  topology.neighbors.resize(mesh.positions.size());
  for (const MeshEdge& edge : topology.edges) {
    topology.neighbors[Index(edge.vertices[0])].push_back(edge.vertices[1]);
    topology.neighbors[Index(edge.vertices[1])].push_back(edge.vertices[0]);
  }
  for (std::vector<std::int32_t>& ring : topology.neighbors) std::sort(ring.begin(), ring.end());
  topology.closed = std::all_of(topology.edges.begin(),
                                topology.edges.end(),
                                [](const MeshEdge& edge) { return edge.faces[1] >= 0; });
  topology.UpdateSolid(mesh);
  return topology;
}

void MeshTopology::UpdateSolid(const Mesh& mesh) { solid = closed && IsWoundOutwards(mesh); }

}  // namespace pathfit::renderer
