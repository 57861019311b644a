#include "renderer/geometry/mesh_folds.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/geometry/near_pairs.h"

namespace pathfit::renderer {
namespace {

constexpr int kPassesPerRing = 6;  // after so many passes one more ring of neighbours moves, too

// Of an edge's length: how far it must pass through a triangle. In flat parts rounding has more
// sides.
constexpr double kLeastDepth = 1e-9;

double Volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return Dot(b - a, Cross(c - a, d - a));
}

/// Whether the edge a..b passes through the inside of the triangle.
bool Pierces(const Vec3& a, const Vec3& b, const Vec3& p, const Vec3& q, const Vec3& r) {
  const double at_a = Volume(p, q, r, a);
  const double at_b = Volume(p, q, r, b);
  const double least = kLeastDepth * Norm(b - a) * Norm(Cross(q - p, r - p));
  if (at_a * at_b >= 0.0 || std::min(std::abs(at_a), std::abs(at_b)) <= least) return false;
  const double u = Volume(a, b, p, q);
  const double v = Volume(a, b, q, r);
  const double w = Volume(a, b, r, p);
  return (u > 0.0 && v > 0.0 && w > 0.0) || (u < 0.0 && v < 0.0 && w < 0.0);
}

/// Whether an edge of `a` that has no corner of `b` pierces `b`.
bool AnyEdgePierces(const Mesh& mesh, const Triangle& a, const Triangle& b) {
  const auto is_shared = [&b](std::int32_t v) { return v == b[0] || v == b[1] || v == b[2]; };
  for (std::size_t k = 0; k < 3; ++k) {
    const std::int32_t from = a[k];
    const std::int32_t to = a[(k + 1) % 3];
    if (!is_shared(from) && !is_shared(to) &&
        Pierces(mesh.positions[Index(from)],
                mesh.positions[Index(to)],
                mesh.positions[Index(b[0])],
                mesh.positions[Index(b[1])],
                mesh.positions[Index(b[2])])) {
      return true;
    }
  }
  return false;
}

std::size_t NumShared(const Triangle& a, const Triangle& b) {
  return static_cast<std::size_t>(std::count_if(
      a.begin(), a.end(), [&b](auto v) { return std::count(b.begin(), b.end(), v); }));
}

std::vector<MeshEdge> FoldedEdges(const Mesh& mesh, const std::vector<MeshEdge>& edges) {
  std::vector<Vec3> normals;
  normals.reserve(mesh.triangles.size());
  for (const Triangle& t : std::as_const(mesh.triangles)) normals.push_back(TwiceArea(mesh, t));
  std::vector<MeshEdge> folded;
  std::copy_if(edges.begin(), edges.end(), std::back_inserter(folded), [&](const MeshEdge& edge) {
    return edge.faces[1] >= 0 &&
           AreFolded(normals[Index(edge.faces[0])], normals[Index(edge.faces[1])]);
  });
  return folded;
}

}  // namespace

bool AreFolded(const Vec3& n_a, const Vec3& n_b) {
  static const double kCosine = std::cos(kFoldAngle * std::numbers::pi / 180.0);
  return Dot(n_a, n_b) < kCosine * Norm(n_a) * Norm(n_b);
}

std::vector<std::int32_t> CrossingTriangles(const Mesh& mesh,
                                            const std::vector<std::int32_t>& parts) {
  std::vector<char> crosses(mesh.triangles.size(), 0);
  const std::vector<TriangleGeometry> geometry = GeometryOf(mesh);
  std::vector<NearItem> items;
  items.reserve(geometry.size());
  for (const TriangleGeometry& triangle : geometry) items.push_back({&triangle});
  ForEachNearPair(items, [&](std::size_t i, std::size_t j) {
    const Triangle& a = mesh.triangles[i];
    const Triangle& b = mesh.triangles[j];
    if (parts[i] == parts[j] && NumShared(a, b) < 2 &&
        (AnyEdgePierces(mesh, a, b) || AnyEdgePierces(mesh, b, a))) {
      crosses[i] = crosses[j] = 1;
    }
  });
  std::vector<std::int32_t> found;
  for (std::size_t t = 0; t < crosses.size(); ++t) {
    if (crosses[t] != 0) found.push_back(static_cast<std::int32_t>(t));
  }
  return found;
}

MeshFolds CountFolds(const Mesh& mesh) {
  const MeshTopology topology = MeshTopology::Build(mesh);
  return {static_cast<int>(FoldedEdges(mesh, topology.edges).size()),
          static_cast<int>(CrossingTriangles(mesh, topology.parts).size())};
}

std::vector<std::int32_t> FoldedTriangles(const Mesh& mesh) {
  const MeshTopology topology = MeshTopology::Build(mesh);
  std::vector<std::int32_t> found = CrossingTriangles(mesh, topology.parts);
  for (const MeshEdge& edge : FoldedEdges(mesh, topology.edges)) {
    found.insert(found.end(), edge.faces.begin(), edge.faces.end());
  }
  std::ranges::sort(found);
  const auto repeated = std::ranges::unique(found);
  found.erase(repeated.begin(), repeated.end());
  return found;
}

MeshFolds Unfold(Mesh& mesh) {
  const MeshTopology topology = MeshTopology::Build(mesh);
  std::vector<char> fixed(mesh.positions.size(), 0);
  for (const MeshEdge& edge : topology.edges) {
    if (edge.faces[1] < 0) fixed[Index(edge.vertices[0])] = fixed[Index(edge.vertices[1])] = 1;
  }
  const std::vector<std::vector<std::int32_t>> rings = topology.Neighbors(mesh);
  const std::vector<Triangle> triangles = mesh.triangles;
  std::optional<MeshFolds> fewest;
  std::vector<Vec3> best;
  for (int pass = 0; pass <= kMaxUnfoldPasses; ++pass) {
    const std::vector<MeshEdge> folded = FoldedEdges(mesh, topology.edges);
    const std::vector<std::int32_t> crossing = CrossingTriangles(mesh, topology.parts);
    const MeshFolds left{static_cast<int>(folded.size()), static_cast<int>(crossing.size())};
    if (!fewest || left.Total() < fewest->Total()) {
      fewest = left;
      best = mesh.positions;
    }
    if (left.Total() == 0 || pass == kMaxUnfoldPasses) break;
    std::vector<char> moves(mesh.positions.size(), 0);
    const auto mark = [&](std::int32_t face) {
      for (const std::int32_t v : triangles[Index(face)]) moves[Index(v)] = 1;
    };
    for (const MeshEdge& edge : folded) {
      mark(edge.faces[0]);
      mark(edge.faces[1]);
    }
    std::for_each(crossing.begin(), crossing.end(), mark);
    for (int ring = 0; ring < pass / kPassesPerRing; ++ring) topology.MarkRing(moves);
    const std::vector<Vec3> old = mesh.positions;
    std::vector<Vec3>& positions = mesh.positions.Edit();
    for (std::size_t v = 0; v < old.size(); ++v) {
      if (moves[v] == 0 || fixed[v] != 0) continue;
      Vec3 sum{0.0, 0.0, 0.0};
      for (const std::int32_t neighbor : rings[v]) sum += old[Index(neighbor)];
      const Vec3 middle = sum / static_cast<double>(rings[v].size());
      // Half of the way: whole steps may swing to and fro.
      positions[v] = (old[v] + middle) * 0.5;
    }
  }
  mesh.positions = std::move(best);
  return *fewest;
}

int CountNeedles(const Mesh& mesh) {
  std::vector<Vec3> sums(mesh.positions.size());
  std::vector<double> areas(mesh.positions.size(), 0.0);
  for (const Triangle& triangle : mesh.triangles) {
    const TriangleGeometry geometry = GeometryOf(mesh, triangle);
    for (const std::int32_t v : triangle) {
      sums[Index(v)] += geometry.n * geometry.double_area;
      areas[Index(v)] += geometry.double_area;
    }
  }
  int count = 0;
  for (std::size_t v = 0; v < sums.size(); ++v) {
    if (Norm(sums[v]) < kNeedleShare * areas[v]) ++count;
  }
  return count;
}

}  // namespace pathfit::renderer
