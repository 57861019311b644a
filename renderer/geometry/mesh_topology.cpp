#include "renderer/geometry/mesh_topology.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <unordered_map>

#include "renderer/core/check.h"
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

/// Around edges with more sides no neighbours are sought: it would take long, and mean nothing.
constexpr std::ptrdiff_t kMaxSides = 64;

/// One side of a triangle: from its corner k to corner k + 1.
struct Side {
  std::int32_t low, high;  ///< vertices, ascending
  std::size_t face;
  std::size_t corner;
  bool ascending;      ///< runs from low to high
  double angle = 0.0;  ///< of the face around the edge, only where there are more than two
};
using SideIterator = std::vector<Side>::iterator;

std::size_t Corner(std::size_t face, std::size_t corner) { return 3 * face + corner % 3; }

/// Sides of all triangles, those of one edge together.
std::vector<Side> SortedSides(const Mesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = mesh.triangles[f][k];
      const std::int32_t b = mesh.triangles[f][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), f, k, a < b});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::pair(std::pair(a.low, a.high), a.face) <
           std::pair(std::pair(b.low, b.high), b.face);
  });
  return sides;
}

/// By the angle about the direction from low to high, beginning with a face that runs downwards if
/// there is one: turning positively, body follows such a face.
void SortAroundEdge(const Mesh& mesh, SideIterator first, SideIterator last) {
  const Vec3& low = mesh.positions[Index(first->low)];
  const Vec3 axis = Normalized(mesh.positions[Index(first->high)] - low);
  Vec3 reference;
  for (auto side = first; side != last; ++side) {
    const Vec3 to_apex =
        mesh.positions[Index(mesh.triangles[side->face][(side->corner + 2) % 3])] - low;
    const Vec3 across = to_apex - axis * Dot(axis, to_apex);
    if (side == first) reference = across;
    side->angle = std::atan2(Dot(axis, Cross(reference, across)), Dot(reference, across));
    // An edge so short that its square vanishes has no angles; they must still be in order.
    if (!std::isfinite(side->angle)) side->angle = 0.0;
  }
  std::sort(first, last, [](const Side& a, const Side& b) {
    return std::pair(a.angle, a.face) < std::pair(b.angle, b.face);
  });
  const auto downwards = std::find_if(first, last, [](const Side& s) { return !s.ascending; });
  if (downwards != last) std::rotate(first, downwards, last);
}

class FanBuilder {
 public:
  explicit FanBuilder(const Mesh& mesh) : mesh_(mesh), corners_(3 * mesh.triangles.size()) {}

  CornerFans Build() {
    std::vector<Side> sides = SortedSides(mesh_);
    for (auto first = sides.begin(); first != sides.end();) {
      const auto last = std::find_if(first, sides.end(), [&](const Side& s) {
        return s.low != first->low || s.high != first->high;
      });
      const auto count = last - first;
      fans_.num_unpaired += static_cast<std::size_t>(count);
      if (count == 2 && first->ascending != (first + 1)->ascending) Pair(*first, *(first + 1));
      if (count > 2) {
        fans_.non_manifold_edges.emplace_back(first->low, first->high);
        SortAroundEdge(mesh_, first, last);
        PairAroundEdge(first, last);
      }
      first = last;
    }
    fans_.fan.resize(3 * mesh_.triangles.size());
    for (std::size_t c = 0; c < fans_.fan.size(); ++c) fans_.fan[c] = corners_.Find(c);
    return std::move(fans_);
  }

 private:
  void Pair(const Side& a, const Side& b) {
    corners_.Unite(Corner(a.face, a.corner), Corner(b.face, b.corner + 1));
    corners_.Unite(Corner(a.face, a.corner + 1), Corner(b.face, b.corner));
    fans_.num_unpaired -= 2;
  }

  void PairAroundEdge(SideIterator first, SideIterator last) {
    bool alternates = (last - first) % 2 == 0;
    for (auto side = first; side != last; ++side) {
      alternates = alternates && side->ascending == ((side - first) % 2 == 1);
    }
    if (alternates) {
      for (auto side = first; side != last; side += 2) Pair(*side, *(side + 1));
      return;
    }
    ++fans_.num_irregular;
    if (last - first > kMaxSides) return;
    std::vector<Side> open(first, last);
    while (true) {
      std::size_t best_a = 0;
      std::size_t best_b = 0;
      double best_bend = std::numeric_limits<double>::infinity();
      for (std::size_t a = 0; a < open.size(); ++a) {
        for (std::size_t b = a + 1; b < open.size(); ++b) {
          const double bend = std::abs(std::abs(open[a].angle - open[b].angle) - std::numbers::pi);
          if (open[a].ascending == open[b].ascending || !(bend < best_bend)) continue;
          best_a = a;
          best_b = b;
          best_bend = bend;
        }
      }
      if (best_b == 0) return;
      Pair(open[best_a], open[best_b]);
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(best_b));
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(best_a));
    }
  }

  const Mesh& mesh_;
  DisjointSets corners_;
  CornerFans fans_;
};

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

CornerFans CornerFans::Build(const Mesh& mesh) { return FanBuilder(mesh).Build(); }

}  // namespace pathfit::renderer
