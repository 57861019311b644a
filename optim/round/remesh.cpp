#include "optim/round/remesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

#include <OpenMesh/Core/Geometry/VectorT.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/geometry/closest_point.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_normals.h"
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
  Remesher(const renderer::Mesh& mesh, double edge)
      : surface_(mesh),
        edge_(edge),
        longest_(kLongest * edge * kLongest * edge),
        shortest_(kShortest * edge * kShortest * edge),
        most_vertices_(4.0 * static_cast<double>(mesh.positions.size()) +
                       kMostPerSquare * SurfaceArea(mesh) / (edge * edge)) {
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
    bool found = false;
    const auto mark = [&](Vertex v) {
      kernel_.status(v).set_tagged(true);
      found = true;
    };
    for (const Edge edge : kernel_.edges()) {
      const Halfedge h = kernel_.halfedge_handle(edge, 0);
      const double length = std::sqrt(SquaredLength(h));
      if (length > kTooLong * edge_ || length < kTooShort * edge_) {
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
      for (const Vertex v : next) kernel_.status(v).set_tagged(true);
    }
    only_tagged_ = true;
    return found;
  }

  void Run() {
    for (int pass = 0; pass < kPasses; ++pass) {
      SplitLong();
      CollapseShort();
      EqualizeValences();
      Relax();
    }
    kernel_.garbage_collection();
  }

  [[nodiscard]] renderer::Mesh Result(const renderer::Mesh& source) const {
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
    if (source.HasColors()) {
      std::vector<renderer::Rgb> colors;
      for (const Vertex v : kernel_.vertices()) {
        const ClosestPoint at = surface_.Closest(At(v), Normal(v));
        const auto& corners = source.color_triangles[static_cast<std::size_t>(at.triangle)];
        renderer::Rgb color{0.0, 0.0, 0.0};
        for (std::size_t k = 0; k < 3; ++k) {
          color += source.colors[static_cast<std::size_t>(corners[k])] * at.weights[k];
        }
        colors.push_back(color);
      }
      mesh.colors = std::move(colors);
      mesh.color_triangles = mesh.triangles;
    }
    if (!source.normal_triangles.empty()) renderer::ComputeVertexNormals(mesh);
    return mesh;
  }

 private:
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
    const double most = kMostOff * edge_;
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
      if (SquaredLength(h) <= longest_) continue;
      const Vec3 middle =
          (At(kernel_.to_vertex_handle(h)) + At(kernel_.from_vertex_handle(h))) * 0.5;
      const Vertex v = kernel_.add_vertex({middle.x, middle.y, middle.z});
      kernel_.status(v).set_tagged(true);
      kernel_.split(edge, v);
      // The first half keeps its number.
      if (SquaredLength(kernel_.halfedge_handle(edge, 0)) > longest_) --i;
    }
  }

  void CollapseShort() {
    for (std::size_t i = 0; i < kernel_.n_edges(); ++i) {
      const Edge edge(static_cast<int>(i));
      if (!MayChange(edge)) continue;
      Halfedge h = kernel_.halfedge_handle(edge, 0);
      if (SquaredLength(h) >= shortest_) continue;
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
      if (v != to && SquaredNorm(At(v) - At(to)) > longest_) return false;
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
        const double most = kMostOff * edge_;
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
        const Vec3 x = surface_.Closest(At(v) + along * step, n).position;
        if (!MayMove(v, x, Vertex(), kMaxTurn) || !KeepsNear(At(v), v, x, Vertex())) continue;
        kernel_.set_point(v, {x.x, x.y, x.z});
        break;
      }
    }
  }

  Kernel kernel_;
  TriangleTree surface_;
  double edge_;
  double longest_, shortest_;  // squared lengths
  double most_vertices_;       // that no sound surface reaches
  bool only_tagged_ = false;
};

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
  Remesher remesher(mesh, edge);
  remesher.Run();
  return remesher.Result(mesh);
}

std::optional<renderer::Mesh> MendEdges(const renderer::Mesh& mesh, double edge) {
  Remesher remesher(mesh, edge);
  if (!remesher.KeepEven()) return std::nullopt;
  remesher.Run();
  return remesher.Result(mesh);
}

double SurfaceDistance(const renderer::Mesh& a, const renderer::Mesh& b) {
  return std::max(DistanceTo(TriangleTree(a), b), DistanceTo(TriangleTree(b), a));
}

}  // namespace pathfit::optim
