#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "renderer/geometry/mesh.h"
#include "renderer/geometry/triangle_kernel.h"

namespace pathfit::renderer {

/// Twice the area over the squared longest edge below which a triangle's normal is rounding noise.
inline constexpr double kMinRelativeArea = 1e-14;

inline std::size_t Index(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Undirected edge as one integer: the smaller index in the high half.
inline std::uint64_t EdgeKey(std::int32_t a, std::int32_t b) {
  const auto [low, high] = std::minmax(a, b);
  return (static_cast<std::uint64_t>(low) << 32) | static_cast<std::uint64_t>(high);
}

/// Side `side % 3` of triangle `side / 3`, from that corner to the next, and its EdgeKey.
struct MeshSide {
  std::uint64_t edge = 0;
  std::size_t side = 0;

  [[nodiscard]] std::size_t Face() const { return side / 3; }
  [[nodiscard]] std::int32_t From(const Mesh& mesh) const {
    return mesh.triangles[Face()][side % 3];
  }
  [[nodiscard]] std::int32_t To(const Mesh& mesh) const {
    return mesh.triangles[Face()][(side + 1) % 3];
  }
};

/// Sides of all triangles: those of one edge together, in the order of the triangles. Precondition:
/// indices in range.
std::vector<MeshSide> SortedSides(const Mesh& mesh);

/// Calls `visit(first, last)` with the iterators of each edge's sides.
template <class Visitor>
void ForEachEdge(const std::vector<MeshSide>& sides, Visitor&& visit) {
  for (auto first = sides.begin(); first != sides.end();) {
    auto last = first + 1;
    while (last != sides.end() && last->edge == first->edge) ++last;
    visit(first, last);
    first = last;
  }
}

inline bool IsInRange(const Triangle& triangle, std::size_t count) {
  return std::all_of(triangle.begin(), triangle.end(), [count](std::int32_t i) {
    return i >= 0 && Index(i) < count;
  });
}

/// The triangle's corners in ascending order: equal for triangles that cover each other.
inline Triangle SortedCorners(Triangle triangle) {
  std::sort(triangle.begin(), triangle.end());
  return triangle;
}

/// Twice the vector area of a triangle.
inline Vec3 TwiceArea(const Mesh& mesh, const Triangle& t) {
  const Vec3& a = mesh.positions[Index(t[0])];
  return Cross(mesh.positions[Index(t[1])] - a, mesh.positions[Index(t[2])] - a);
}

inline TriangleGeometry GeometryOf(const Mesh& mesh, const Triangle& t) {
  return TriangleGeometry::Make(
      mesh.positions[Index(t[0])], mesh.positions[Index(t[1])], mesh.positions[Index(t[2])]);
}

/// Unit normal of a triangle by its winding.
inline Vec3 TriangleNormal(const Mesh& mesh, std::int32_t triangle) {
  return GeometryOf(mesh, mesh.triangles[Index(triangle)]).n;
}

/// Whether the point is outside the box around the mesh.
bool IsOutsideBox(const Mesh& mesh, const Vec3& x);

inline double SurfaceArea(const Mesh& mesh) {
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles) {
    sum += 0.5 * Norm(TwiceArea(mesh, t));
  }
  return sum;
}

/// Of all triangles.
std::vector<TriangleGeometry> GeometryOf(const Mesh& mesh);

inline double SquaredLongestEdge(const Mesh& mesh, const Triangle& t) {
  const Vec3& a = mesh.positions[Index(t[0])];
  const Vec3& b = mesh.positions[Index(t[1])];
  const Vec3& c = mesh.positions[Index(t[2])];
  return std::max({SquaredNorm(b - a), SquaredNorm(c - b), SquaredNorm(a - c)});
}

/// The part of ValidateMesh that makes the arrays safe to read: there is a triangle, all numbers
/// are finite, and the index lists fit the arrays.
void ValidateMeshArrays(const Mesh& mesh, const std::string& name);

/// Position, normal, UV and colour indices of a mesh: what any change of its triangles must treat
/// alike. Lists of absent attributes are empty.
template <class Visitor>
void ForEachTriangleList(Mesh& mesh, Visitor&& visit) {
  for (SharedVector<Triangle>* list :
       {&mesh.triangles, &mesh.normal_triangles, &mesh.uv_triangles, &mesh.color_triangles}) {
    if (!list->empty()) {
      visit(list->Edit());
    }
  }
}

}  // namespace pathfit::renderer
