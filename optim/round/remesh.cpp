#include "optim/round/remesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include <OpenMesh/Core/Geometry/VectorT.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/geometry/closest_point.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_folds.h"
#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/geometry/triangle_tree.h"

namespace pathfit::optim {
namespace {

using renderer::ClosestPoint;
using renderer::TriangleTree;
using renderer::Vec3;

constexpr int kPasses = 8;
constexpr double kLongest = 4.0 / 3.0, kShortest = 4.0 / 5.0;  // of the wanted length
constexpr double kMaxTurn = 0.5;    // least cosine between a normal before and after a collapse
constexpr double kThinnest = 0.05;  // least twice-area over squared longest side that a move leaves
constexpr int kMaxValence = 12;
// What a moving mesh has stretched, crushed or flattened; twice the area over squared side.
constexpr double kTooLong = 2.0, kTooShort = 0.4;  // of the wanted length
constexpr double kTooThin = 0.15;
constexpr int kRings = 2;          // of neighbours that help to mend it
constexpr double kMostOff = 0.03;  // of the wanted length: how far mending leaves what was there
constexpr double kMostPerSquare = 16.0;  // vertices; equal sides give 1.15
// Parts that were made with shorter edges: their mean over so many rings is below it.
constexpr int kRingsOfMean = 3;
constexpr double kFine = 0.5;
// Thin parts.
constexpr int kMostHalvings = 4;
constexpr double kGrading = 0.5;  // of lengths, per distance

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  VertexAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status);
  HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge);
};
using Kernel = OpenMesh::TriMesh_ArrayKernelT<Traits>;
using Vertex = OpenMesh::VertexHandle;
using Halfedge = OpenMesh::HalfedgeHandle;
using Edge = OpenMesh::EdgeHandle;
using Face = OpenMesh::FaceHandle;

Vec3 FromPoint(const OpenMesh::Vec3d& p) { return {p[0], p[1], p[2]}; }

/// Twice the area over the squared longest side: 0.87 for equal sides.
double Shape(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double longest = std::max({SquaredNorm(b - a), SquaredNorm(c - b), SquaredNorm(a - c)});
  return longest > 0.0 ? Norm(Cross(b - a, c - a)) / longest : 0.0;
}

class Remesher {
 public:
  /// `lengths`: of edges, by vertex of the mesh, which is that of the tree.
  Remesher(const renderer::Mesh& mesh, const TriangleTree& surface, std::vector<double> lengths)
      : mesh_(mesh), surface_(surface), lengths_(std::move(lengths)) {
    const std::vector<renderer::Vec3>& positions = mesh.positions;
    for (const Vec3& p : positions) {
      kernel_.add_vertex({p.x, p.y, p.z});
    }
    const std::vector<renderer::Triangle>& triangles = mesh.triangles;
    for (const renderer::Triangle& t : triangles) {
      const Face face = kernel_.add_face(Vertex(t[0]), Vertex(t[1]), Vertex(t[2]));
      if (!face.is_valid()) {
        throw renderer::SceneError("a vertex joins parts of the surface that share no edge there");
      }
    }
  }

  /// Restricts all changes to where edges and triangles are too uneven, and a few rings of
  /// neighbours. False: they are not.
  bool KeepEven() {
    const std::vector<char> is_fine = FindFineParts();
    bool found = false;
    const auto mark = [&](Vertex v) {
      if (is_fine[Index(v)] != 0) return;
      kernel_.status(v).set_tagged(true);
      found = true;
    };
    for (const Edge edge : kernel_.edges()) {
      const Halfedge h = kernel_.halfedge_handle(edge, 0);
      const double share = std::sqrt(SquaredLength(h)) / Wanted(h);
      if (share > kTooLong || share < kTooShort) {
        mark(kernel_.to_vertex_handle(h));
        mark(kernel_.from_vertex_handle(h));
      }
    }
    for (const Face face : kernel_.faces()) {
      const Halfedge h = kernel_.halfedge_handle(face);
      const Vertex a = kernel_.from_vertex_handle(h), b = kernel_.to_vertex_handle(h);
      if (Shape(At(a), At(b), Apex(h)) < kTooThin) {
        for (const Vertex v : kernel_.fv_range(face)) mark(v);
      }
    }
    for (int ring = 0; ring < kRings; ++ring) {
      std::vector<Vertex> next;
      for (const Vertex v : kernel_.vertices()) {
        if (!kernel_.status(v).tagged()) continue;
        for (const Vertex neighbor : kernel_.vv_range(v)) next.push_back(neighbor);
      }
      std::ranges::for_each(next, mark);
    }
    only_tagged_ = true;
    return found;
  }

  void Run() {
    lengths_of_surface_ = lengths_;
    most_vertices_ = 4.0 * static_cast<double>(lengths_.size()) + kMostPerSquare * WantedSquares();
    for (int pass = 0; pass < kPasses; ++pass) {
      SplitLong();
      CollapseShort();
      EqualizeValences();
      Relax();
    }
    kernel_.garbage_collection();
  }

  [[nodiscard]] renderer::Mesh Result() const {
    renderer::Mesh mesh;
    std::vector<Vec3> positions;
    for (const Vertex v : kernel_.vertices()) positions.push_back(At(v));
    std::vector<renderer::Triangle> triangles;
    for (const Face f : kernel_.faces()) {
      renderer::Triangle t{};
      std::size_t k = 0;
      for (const Vertex v : kernel_.fv_range(f)) t[k++] = v.idx();
      triangles.push_back(t);
    }
    mesh.positions = std::move(positions);
    mesh.triangles = std::move(triangles);
    if (mesh_.HasColors()) {
      std::vector<renderer::Rgb> colors;
      for (const Vertex v : kernel_.vertices()) {
        const ClosestPoint at = surface_.Closest(At(v), Normal(v));
        const auto& corners = mesh_.color_triangles[static_cast<std::size_t>(at.triangle)];
        renderer::Rgb color{0.0, 0.0, 0.0};
        for (std::size_t k = 0; k < 3; ++k) {
          color += mesh_.colors[static_cast<std::size_t>(corners[k])] * at.weights[k];
        }
        colors.push_back(color);
      }
      mesh.colors = std::move(colors);
      mesh.color_triangles = mesh.triangles;
    }
    if (!mesh_.normal_triangles.empty()) renderer::ComputeVertexNormals(mesh);
    return mesh;
  }

 private:
  /// Vertices with far shorter edges all around than wanted: such parts were made so.
  [[nodiscard]] std::vector<char> FindFineParts() const {
    std::vector<double> means(lengths_.size());
    for (const Vertex v : kernel_.vertices()) {
      double sum = 0.0;
      for (const Halfedge h : kernel_.voh_range(v)) sum += std::sqrt(SquaredLength(h));
      means[Index(v)] = sum / static_cast<double>(kernel_.valence(v));
    }
    for (int ring = 0; ring < kRingsOfMean; ++ring) {
      const std::vector<double> inner = means;
      for (const Vertex v : kernel_.vertices()) {
        double sum = inner[Index(v)];
        for (const Vertex neighbor : kernel_.vv_range(v)) sum += inner[Index(neighbor)];
        means[Index(v)] = sum / static_cast<double>(kernel_.valence(v) + 1);
      }
    }
    std::vector<char> is_fine(means.size());
    for (std::size_t v = 0; v < means.size(); ++v) is_fine[v] = means[v] < kFine * lengths_[v];
    return is_fine;
  }
  /// Area in squares of the wanted lengths.
  [[nodiscard]] double WantedSquares() const {
    double sum = 0.0;
    for (const Face face : kernel_.faces()) {
      const Halfedge h = kernel_.halfedge_handle(face);
      const Vertex a = kernel_.from_vertex_handle(h), b = kernel_.to_vertex_handle(h);
      const double wanted = Wanted(h);
      sum += 0.5 * Norm(Cross(At(b) - At(a), Apex(h) - At(a))) / (wanted * wanted);
    }
    return sum;
  }
  static std::size_t Index(Vertex v) { return static_cast<std::size_t>(v.idx()); }
  /// Length of an edge between two places.
  [[nodiscard]] double Wanted(Vertex a, Vertex b) const {
    return 0.5 * (lengths_[Index(a)] + lengths_[Index(b)]);
  }
  [[nodiscard]] double Wanted(Halfedge h) const {
    return Wanted(kernel_.from_vertex_handle(h), kernel_.to_vertex_handle(h));
  }
  [[nodiscard]] bool IsLong(Halfedge h) const {
    const double longest = kLongest * Wanted(h);
    return SquaredLength(h) > longest * longest;
  }
  [[nodiscard]] double LengthAt(const ClosestPoint& at) const {
    const auto& corners = mesh_.triangles[static_cast<std::size_t>(at.triangle)];
    double length = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      length += lengths_of_surface_[static_cast<std::size_t>(corners[k])] * at.weights[k];
    }
    return length;
  }

  [[nodiscard]] bool MayChange(Vertex v) const {
    return !only_tagged_ || kernel_.status(v).tagged();
  }
  [[nodiscard]] bool MayChange(Edge edge) const {
    const Halfedge h = kernel_.halfedge_handle(edge, 0);
    return !kernel_.status(edge).deleted() && MayChange(kernel_.to_vertex_handle(h)) &&
           MayChange(kernel_.from_vertex_handle(h));
  }
  /// Whether the triangles around v, but for those at `without`, pass near the point p when v is at
  /// x: mending must not cut corners. Anything does where the whole mesh is made anew.
  [[nodiscard]] bool KeepsNear(const Vec3& p, Vertex v, const Vec3& x, Vertex without) const {
    if (!only_tagged_) return true;
    const double most = kMostOff * lengths_[Index(v)];
    for (const Halfedge h : kernel_.voh_range(v)) {
      const Vertex a = kernel_.to_vertex_handle(h);
      const Vertex b = kernel_.to_vertex_handle(kernel_.next_halfedge_handle(h));
      if (a == without || b == without) continue;
      if (IsNear(p, x, At(a), At(b), most)) return true;
    }
    return false;
  }
  static bool IsNear(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, double most) {
    const auto triangle = renderer::TriangleGeometry::Make(a, b, c);
    return SquaredNorm(renderer::ClosestPointOfTriangle(p, triangle) - p) <= most * most;
  }
  [[nodiscard]] Vec3 At(Vertex v) const { return FromPoint(kernel_.point(v)); }
  [[nodiscard]] double SquaredLength(Halfedge h) const {
    return SquaredNorm(At(kernel_.to_vertex_handle(h)) - At(kernel_.from_vertex_handle(h)));
  }
  [[nodiscard]] Vec3 Apex(Halfedge h) const {
    return At(kernel_.to_vertex_handle(kernel_.next_halfedge_handle(h)));
  }

  /// Sum of the area vectors around a vertex.
  [[nodiscard]] Vec3 Normal(Vertex v) const {
    Vec3 sum{0.0, 0.0, 0.0};
    for (const Halfedge h : kernel_.voh_range(v)) {
      sum += Cross(At(kernel_.to_vertex_handle(h)) - At(v), Apex(h) - At(v));
    }
    return SquaredNorm(sum) > 0.0 ? sum : Vec3{0.0, 0.0, 1.0};
  }

  /// Whether the triangles around v, but for those at `without`, keep their side and get not too
  /// thin when v moves to x.
  [[nodiscard]] bool MayMove(Vertex v, const Vec3& x, Vertex without, double least_cosine) const {
    for (const Halfedge h : kernel_.voh_range(v)) {
      const Vertex a = kernel_.to_vertex_handle(h);
      const Vertex b = kernel_.to_vertex_handle(kernel_.next_halfedge_handle(h));
      if (a == without || b == without) continue;
      const Vec3 before = Cross(At(a) - At(v), At(b) - At(v));
      const Vec3 after = Cross(At(a) - x, At(b) - x);
      if (Dot(before, after) < least_cosine * Norm(before) * Norm(after)) return false;
      const double shape = Shape(x, At(a), At(b));
      if (shape < kThinnest && shape <= Shape(At(v), At(a), At(b))) return false;
    }
    return true;
  }

  void SplitLong() {
    if (static_cast<double>(kernel_.n_vertices()) > most_vertices_) {
      throw renderer::SceneError("it is too crumpled for edges of one length");
    }
    // Halves of very long edges are again long: they come at the end of the list.
    for (std::size_t i = 0; i < kernel_.n_edges(); ++i) {
      const Edge edge(static_cast<int>(i));
      if (!MayChange(edge)) continue;
      const Halfedge h = kernel_.halfedge_handle(edge, 0);
      if (!IsLong(h)) continue;
      const double wanted = Wanted(h);
      const Vec3 middle =
          (At(kernel_.to_vertex_handle(h)) + At(kernel_.from_vertex_handle(h))) * 0.5;
      const Vertex v = kernel_.add_vertex({middle.x, middle.y, middle.z});
      lengths_.push_back(wanted);
      kernel_.status(v).set_tagged(true);
      kernel_.split(edge, v);
      // The first half keeps its number.
      if (IsLong(kernel_.halfedge_handle(edge, 0))) --i;
    }
  }

  void CollapseShort() {
    for (std::size_t i = 0; i < kernel_.n_edges(); ++i) {
      const Edge edge(static_cast<int>(i));
      if (!MayChange(edge)) continue;
      Halfedge h = kernel_.halfedge_handle(edge, 0);
      const double shortest = kShortest * Wanted(h);
      if (SquaredLength(h) >= shortest * shortest) continue;
      for (int side = 0; side < 2; ++side) {
        h = kernel_.halfedge_handle(edge, static_cast<unsigned>(side));
        if (MayCollapse(h)) {
          kernel_.collapse(h);
          break;
        }
      }
    }
  }

  /// Whether the vertex at the beginning may become that at the end.
  [[nodiscard]] bool MayCollapse(Halfedge h) {
    if (!kernel_.is_collapse_ok(h)) return false;
    const Vertex from = kernel_.from_vertex_handle(h);
    const Vertex to = kernel_.to_vertex_handle(h);
    for (const Vertex v : kernel_.vv_range(from)) {
      const double longest = kLongest * Wanted(v, to);
      if (v != to && SquaredNorm(At(v) - At(to)) > longest * longest) return false;
    }
    const auto valence = static_cast<int>(kernel_.valence(from) + kernel_.valence(to)) - 4;
    return valence <= kMaxValence && MayMove(from, At(to), to, kMaxTurn) &&
           KeepsNear(At(from), from, At(to), to);
  }

  void EqualizeValences() {
    for (std::size_t i = 0; i < kernel_.n_edges(); ++i) {
      const Edge edge(static_cast<int>(i));
      if (!MayChange(edge) || !kernel_.is_flip_ok(edge)) continue;
      const Halfedge h = kernel_.halfedge_handle(edge, 0);
      const Halfedge o = kernel_.opposite_halfedge_handle(h);
      const std::array<Vertex, 4> v = {kernel_.from_vertex_handle(h),
                                       kernel_.to_vertex_handle(h),
                                       kernel_.to_vertex_handle(kernel_.next_halfedge_handle(h)),
                                       kernel_.to_vertex_handle(kernel_.next_halfedge_handle(o))};
      int before = 0;
      int after = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        const int excess = static_cast<int>(kernel_.valence(v[k])) - 6;
        before += excess * excess;
        const int changed = excess + (k < 2 ? -1 : 1);
        after += changed * changed;
      }
      if (kernel_.valence(v[0]) <= 3 || kernel_.valence(v[1]) <= 3) continue;
      const Vec3 a = At(v[0]), b = At(v[1]), c = At(v[2]), d = At(v[3]);
      const double thin_before = std::min(Shape(a, b, c), Shape(b, a, d));
      const double thin_after = std::min(Shape(a, d, c), Shape(b, c, d));
      const bool better = after < before
                              ? thin_after > std::min(0.3, thin_before)
                              : thin_before < 2.0 * kThinnest && thin_after > 2.0 * thin_before;
      if (!better) continue;
      if (only_tagged_) {
        const Vec3 middle = (a + b) * 0.5;
        const double most = kMostOff * Wanted(h);
        if (!IsNear(middle, a, d, c, most) && !IsNear(middle, b, c, d, most)) continue;
      }
      // Both new triangles must look where both old ones do.
      const Vec3 old_1 = Cross(b - a, c - a), old_2 = Cross(a - b, d - b);
      const Vec3 new_1 = Cross(d - a, c - a), new_2 = Cross(c - b, d - b);
      const auto agree = [](const Vec3& m, const Vec3& n) {
        return Dot(m, n) > kMaxTurn * Norm(m) * Norm(n);
      };
      const Vec3 mean = old_1 + old_2;
      if (agree(mean, new_1) && agree(mean, new_2) && agree(new_1, new_2)) kernel_.flip(edge);
    }
  }

  /// Each vertex towards the middle of its neighbours, along the surface, and back onto it.
  void Relax() {
    for (const Vertex v : kernel_.vertices()) {
      if (kernel_.status(v).deleted() || !MayChange(v)) continue;
      Vec3 sum{0.0, 0.0, 0.0};
      double count = 0.0;
      for (const Vertex neighbor : kernel_.vv_range(v)) {
        sum += At(neighbor);
        count += 1.0;
      }
      if (count == 0.0) continue;
      const Vec3 n = Normalized(Normal(v));
      const Vec3 middle = sum / count;
      const Vec3 along = middle - At(v) - n * Dot(n, middle - At(v));
      for (const double step : {1.0, 0.3}) {
        const ClosestPoint there = surface_.Closest(At(v) + along * step, n);
        const Vec3& x = there.position;
        if (!MayMove(v, x, Vertex(), kMaxTurn) || !KeepsNear(At(v), v, x, Vertex())) continue;
        kernel_.set_point(v, {x.x, x.y, x.z});
        lengths_[Index(v)] = LengthAt(there);
        break;
      }
    }
  }

  const renderer::Mesh& mesh_;
  const TriangleTree& surface_;
  Kernel kernel_;
  std::vector<double> lengths_;             // by vertex of the kernel
  std::vector<double> lengths_of_surface_;  // by vertex of the mesh
  double most_vertices_ = 0.0;              // that no sound surface reaches
  bool only_tagged_ = false;
};

/// Vertices of `mesh` that `made` is farther away from than `most`, or, with `and_folds`, that it
/// is folded at.
std::vector<std::size_t> LostPlaces(const renderer::Mesh& mesh,
                                    const TriangleTree& surface,
                                    const renderer::Mesh& made,
                                    double most,
                                    bool and_folds) {
  std::vector<Vec3> normals(mesh.positions.size());
  for (const renderer::Triangle& triangle : mesh.triangles) {
    const Vec3 area = renderer::TwiceArea(mesh, triangle);
    for (const std::int32_t v : triangle) normals[static_cast<std::size_t>(v)] += area;
  }
  const TriangleTree made_surface(made);
  std::vector<char> is_lost(normals.size(), 0);
  renderer::ParallelFor(static_cast<std::int64_t>(normals.size()), [&](std::int64_t i) {
    const auto v = static_cast<std::size_t>(i);
    const Vec3& x = mesh.positions[v];
    if (SquaredNorm(normals[v]) == 0.0) return;
    const Vec3 off = made_surface.Closest(x, normals[v]).position - x;
    is_lost[v] = SquaredNorm(off) > most * most ? 1 : 0;
  });
  const std::vector<std::int32_t> folded =
      and_folds ? renderer::FoldedTriangles(made) : std::vector<std::int32_t>();
  for (const std::int32_t face : folded) {
    for (const std::int32_t corner : made.triangles[static_cast<std::size_t>(face)]) {
      const ClosestPoint at = surface.Closest(made.positions[static_cast<std::size_t>(corner)]);
      for (const std::int32_t v : mesh.triangles[static_cast<std::size_t>(at.triangle)]) {
        is_lost[static_cast<std::size_t>(v)] = 1;
      }
    }
  }
  std::vector<std::size_t> lost;
  for (std::size_t v = 0; v < is_lost.size(); ++v) {
    if (is_lost[v] != 0) lost.push_back(v);
  }
  return lost;
}

/// Halves the lengths at these vertices, and makes others shorter around them.
void Halve(const renderer::Mesh& mesh,
           const std::vector<std::size_t>& places,
           std::vector<double>& lengths) {
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> next;
  for (const std::size_t v : places) {
    lengths[v] *= 0.5;
    next.emplace(lengths[v], v);
  }
  const auto rings = renderer::MeshTopology::Build(mesh).Neighbors(mesh);
  while (!next.empty()) {
    const auto [length, v] = next.top();
    next.pop();
    if (length > lengths[v]) continue;
    for (const std::int32_t neighbor : rings[v]) {
      const auto w = static_cast<std::size_t>(neighbor);
      const double most = length + kGrading * Norm(mesh.positions[w] - mesh.positions[v]);
      if (most >= lengths[w]) continue;
      lengths[w] = most;
      next.emplace(most, w);
    }
  }
}

double DistanceTo(const TriangleTree& tree, const renderer::Mesh& mesh) {
  const std::vector<renderer::Triangle>& triangles = mesh.triangles;
  const auto add = [&](std::int64_t i, double& largest) {
    const renderer::Triangle& t = triangles[static_cast<std::size_t>(i)];
    const std::array<Vec3, 3> p = {mesh.positions[static_cast<std::size_t>(t[0])],
                                   mesh.positions[static_cast<std::size_t>(t[1])],
                                   mesh.positions[static_cast<std::size_t>(t[2])]};
    for (const Vec3& x : {p[0],
                          (p[0] + p[1]) * 0.5,
                          (p[1] + p[2]) * 0.5,
                          (p[2] + p[0]) * 0.5,
                          (p[0] + p[1] + p[2]) / 3.0}) {
      largest = std::max(largest, Norm(tree.Closest(x).position - x));
    }
  };
  double largest = 0.0;  // of a mesh without triangles, too
  for (const double distance :
       renderer::ParallelParts<double>(static_cast<std::int64_t>(triangles.size()), add)) {
    largest = std::max(largest, distance);
  }
  return largest;
}

}  // namespace

renderer::Mesh Remesh(const renderer::Mesh& mesh, double edge) {
  const TriangleTree surface(mesh);
  Remesher remesher(mesh, surface, std::vector<double>(mesh.positions.size(), edge));
  remesher.Run();
  return remesher.Result();
}

renderer::Mesh RemeshKeepingThinParts(const renderer::Mesh& mesh, double edge) {
  const TriangleTree surface(mesh);
  std::vector<double> lengths(mesh.positions.size(), edge);
  const auto make = [&] {
    Remesher remesher(mesh, surface, lengths);
    remesher.Run();
    return remesher.Result();
  };
  renderer::Mesh made = make();
  const bool has_folds = !renderer::FoldedTriangles(mesh).empty();
  for (int halvings = 0; halvings < kMostHalvings; ++halvings) {
    const std::vector<std::size_t> lost =
        LostPlaces(mesh, surface, made, kMostLost * edge, !has_folds);
    if (lost.empty()) break;
    Halve(mesh, lost, lengths);
    try {
      made = make();
    } catch (const renderer::SceneError&) {
      break;  // too crumpled for that, or parts that only touch
    }
  }
  return made;
}

std::optional<renderer::Mesh> MendEdges(const renderer::Mesh& mesh, double edge) {
  const TriangleTree surface(mesh);
  Remesher remesher(mesh, surface, std::vector<double>(mesh.positions.size(), edge));
  if (!remesher.KeepEven()) return std::nullopt;
  remesher.Run();
  return remesher.Result();
}

double SurfaceDistance(const renderer::Mesh& a, const renderer::Mesh& b) {
  return std::max(DistanceTo(TriangleTree(a), b), DistanceTo(TriangleTree(b), a));
}

}  // namespace pathfit::optim
