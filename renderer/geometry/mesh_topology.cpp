#include "renderer/geometry/mesh_topology.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

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

/// A side of an edge with more than two triangles.
struct Side {
  MeshSide side;
  bool ascending = false;  ///< runs from the smaller vertex to the larger
  double angle = 0.0;      ///< of the face around the edge
};
using SideIterator = std::vector<Side>::iterator;

std::size_t Corner(const MeshSide& side, std::size_t k) {
  return 3 * side.Face() + (side.side + k) % 3;
}

/// By the angle about the direction from low to high, beginning with a face that runs downwards if
/// there is one: turning positively, body follows such a face.
void SortAroundEdge(const Mesh& mesh, SideIterator first, SideIterator last) {
  const std::int32_t from = first->side.From(mesh);
  const std::int32_t to = first->side.To(mesh);
  const Vec3& low = mesh.positions[Index(std::min(from, to))];
  const Vec3 axis = Normalized(mesh.positions[Index(std::max(from, to))] - low);
  Vec3 reference;
  for (auto side = first; side != last; ++side) {
    const Triangle& face = mesh.triangles[side->side.Face()];
    const Vec3 to_apex = mesh.positions[Index(face[(side->side.side + 2) % 3])] - low;
    const Vec3 across = to_apex - axis * Dot(axis, to_apex);
    if (side == first) reference = across;
    side->angle = std::atan2(Dot(axis, Cross(reference, across)), Dot(reference, across));
    // An edge so short that its square vanishes has no angles; they must still be in order.
    if (!std::isfinite(side->angle)) side->angle = 0.0;
  }
  std::sort(first, last, [](const Side& a, const Side& b) {
    return std::pair(a.angle, a.side.side) < std::pair(b.angle, b.side.side);
  });
  const auto downwards = std::find_if(first, last, [](const Side& s) { return !s.ascending; });
  if (downwards != last) std::rotate(first, downwards, last);
}

class FanBuilder {
 public:
  explicit FanBuilder(const Mesh& mesh) : mesh_(mesh), corners_(3 * mesh.triangles.size()) {}

  CornerFans Build() {
    const std::vector<MeshSide> sides = SortedSides(mesh_);
    ForEachEdge(sides, [this](auto first, auto last) {
      const auto count = last - first;
      fans_.num_unpaired += static_cast<std::size_t>(count);
      if (count == 2 && first->From(mesh_) == (first + 1)->To(mesh_)) Pair(*first, *(first + 1));
      if (count <= 2) return;
      fans_.non_manifold_edges.emplace_back(std::minmax(first->From(mesh_), first->To(mesh_)));
      std::vector<Side> around;
      for (auto side = first; side != last; ++side) {
        around.push_back({*side, side->From(mesh_) < side->To(mesh_), 0.0});
      }
      SortAroundEdge(mesh_, around.begin(), around.end());
      PairAroundEdge(around.begin(), around.end());
    });
    fans_.fan.resize(3 * mesh_.triangles.size());
    for (std::size_t c = 0; c < fans_.fan.size(); ++c) fans_.fan[c] = corners_.Find(c);
    return std::move(fans_);
  }

 private:
  void Pair(const MeshSide& a, const MeshSide& b) {
    corners_.Unite(Corner(a, 0), Corner(b, 1));
    corners_.Unite(Corner(a, 1), Corner(b, 0));
    fans_.num_unpaired -= 2;
  }

  void PairAroundEdge(SideIterator first, SideIterator last) {
    bool alternates = (last - first) % 2 == 0;
    for (auto side = first; side != last; ++side) {
      alternates = alternates && side->ascending == ((side - first) % 2 == 1);
    }
    if (alternates) {
      for (auto side = first; side != last; side += 2) Pair(side->side, (side + 1)->side);
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
      Pair(open[best_a].side, open[best_b].side);
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(best_b));
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(best_a));
    }
  }

  const Mesh& mesh_;
  DisjointSets corners_;
  CornerFans fans_;
};

/// Numbers parts of triangles that edges join, in the order of their first triangles.
std::vector<std::int32_t> PartsOf(const std::vector<MeshEdge>& edges, std::size_t num_triangles) {
  DisjointSets sets(num_triangles);
  for (const MeshEdge& edge : edges) {
    if (edge.faces[1] >= 0) {
      sets.Unite(static_cast<std::size_t>(edge.faces[0]), static_cast<std::size_t>(edge.faces[1]));
    }
  }
  std::vector<std::int32_t> parts(num_triangles);
  std::int32_t count = 0;
  for (std::size_t f = 0; f < num_triangles; ++f) {
    const std::size_t first = sets.Find(f);
    parts[f] = first == f ? count++ : parts[first];
  }
  return parts;
}

}  // namespace

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

std::vector<TriangleGeometry> GeometryOf(const Mesh& mesh) {
  std::vector<TriangleGeometry> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    const auto p = [&](std::size_t i) { return mesh.positions[Index(t[i])]; };
    triangles.push_back(TriangleGeometry::Make(p(0), p(1), p(2)));
  }
  return triangles;
}

std::vector<MeshSide> SortedSides(const Mesh& mesh) {
  // Each side has its place among those of its lower vertex; few are left to be sorted.
  std::vector<std::size_t> end_of(mesh.positions.size() + 1, 0);
  const auto for_each_side = [&mesh](auto visit) {
    std::size_t side = 0;
    for (const Triangle& t : mesh.triangles) {
      for (std::size_t k = 0; k < 3; ++k, ++side) visit(t[k], t[(k + 1) % 3], side);
    }
  };
  for_each_side([&](std::int32_t from, std::int32_t to, std::size_t /*side*/) {
    ++end_of[Index(std::min(from, to)) + 1];
  });
  std::partial_sum(end_of.begin(), end_of.end(), end_of.begin());
  std::vector<MeshSide> sides(3 * mesh.triangles.size());
  for_each_side([&](std::int32_t from, std::int32_t to, std::size_t side) {
    sides[end_of[Index(std::min(from, to))]++] = {EdgeKey(from, to), side};
  });
  auto first = sides.begin();
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto last = sides.begin() + static_cast<std::ptrdiff_t>(end_of[v]);
    std::sort(first, last, [](const MeshSide& a, const MeshSide& b) {
      return std::pair(a.edge, a.side) < std::pair(b.edge, b.side);
    });
    first = last;
  }
  return sides;
}

MeshTopology MeshTopology::Build(const Mesh& mesh) {
  MeshTopology topology;
  const std::vector<MeshSide> sides = SortedSides(mesh);
  // The other side of an edge's first side, itself at a border; of its second side kNobody.
  constexpr std::size_t kNobody = static_cast<std::size_t>(-1);
  std::vector<std::size_t> partner(3 * mesh.triangles.size(), kNobody);
  ForEachEdge(sides, [&](auto first, auto last) {
    PATHFIT_CHECK(last - first <= 2);
    partner[first->side] = (last - 1)->side;
  });
  const auto corner = [&mesh](std::size_t side, std::size_t k) {
    return mesh.triangles[side / 3][(side + k) % 3];
  };
  // Edges stand in the order in which the triangles first mention them.
  for (std::size_t side = 0; side < partner.size(); ++side) {
    const std::size_t other = partner[side];
    if (other == kNobody) continue;
    MeshEdge edge{{corner(side, 0), corner(side, 1)},
                  {static_cast<std::int32_t>(side / 3), -1},
                  {corner(side, 2), -1}};
    if (other != side) {
      PATHFIT_CHECK(corner(other, 0) == edge.vertices[1]);
      edge.faces[1] = static_cast<std::int32_t>(other / 3);
      edge.apex[1] = corner(other, 2);
    }
    topology.edges.push_back(edge);
  }
  topology.parts = PartsOf(topology.edges, mesh.triangles.size());
  topology.closed = std::all_of(topology.edges.begin(),
                                topology.edges.end(),
                                [](const MeshEdge& edge) { return edge.faces[1] >= 0; });
  topology.UpdateSolid(mesh);
  return topology;
}

void MeshTopology::UpdateSolid(const Mesh& mesh) { solid = closed && IsWoundOutwards(mesh); }

double MeshTopology::MeanEdgeLength(const Mesh& mesh) const {
  double sum = 0.0;
  for (const MeshEdge& edge : edges) {
    sum += Norm(mesh.positions[Index(edge.vertices[0])] - mesh.positions[Index(edge.vertices[1])]);
  }
  return sum / static_cast<double>(edges.size());
}

std::vector<std::vector<std::int32_t>> MeshTopology::Neighbors(const Mesh& mesh) const {
  std::vector<std::vector<std::int32_t>> neighbors(mesh.positions.size());
  for (std::vector<std::int32_t>& ring : neighbors) ring.reserve(6);  // most have so many
  for (const MeshEdge& edge : edges) {
    neighbors[Index(edge.vertices[0])].push_back(edge.vertices[1]);
    neighbors[Index(edge.vertices[1])].push_back(edge.vertices[0]);
  }
  for (std::vector<std::int32_t>& ring : neighbors) std::sort(ring.begin(), ring.end());
  return neighbors;
}

void MeshTopology::MarkRing(std::vector<char>& marks) const {
  const std::vector<char> before = marks;
  for (const MeshEdge& edge : edges) {
    const auto [a, b] = edge.vertices;
    if (before[Index(a)] != 0) marks[Index(b)] = 1;
    if (before[Index(b)] != 0) marks[Index(a)] = 1;
  }
}

std::vector<std::array<std::int32_t, 3>> MeshTopology::EdgesOfTriangles() const {
  std::vector<std::array<std::int32_t, 3>> edges_of(parts.size(), {-1, -1, -1});
  for (std::size_t e = 0; e < edges.size(); ++e) {
    for (const std::int32_t face : edges[e].faces) {
      if (face >= 0) {
        auto& of = edges_of[Index(face)];
        *std::find(of.begin(), of.end(), -1) = static_cast<std::int32_t>(e);
      }
    }
  }
  return edges_of;
}

CornerFans CornerFans::Build(const Mesh& mesh) { return FanBuilder(mesh).Build(); }

}  // namespace pathfit::renderer
