#include "renderer/io/mesh_assembly.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/geometry/mesh_normals.h"

namespace pathfit::renderer {
namespace {

/// Bounds the time for polygons with very many corners.
constexpr std::size_t kMaxApexTries = 256;

using Ring = std::vector<std::size_t>;

/// Corners that differ from the one before them, around the polygon.
Ring DistinctCorners(std::span<const Vec3> corners) {
  Ring ring;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (ring.empty() || !(corners[i] == corners[ring.back()])) ring.push_back(i);
  }
  while (ring.size() > 1 && corners[ring.front()] == corners[ring.back()]) ring.pop_back();
  return ring;
}

/// Twice the smallest area of the fan's triangles, signed along the unit `normal`.
double SmallestSignedArea(std::span<const Vec3> corners,
                          const Ring& ring,
                          std::size_t apex,
                          const Vec3& normal) {
  const std::size_t count = ring.size();
  const Vec3& a = corners[ring[apex]];
  double smallest = HUGE_VAL;
  for (std::size_t k = 1; k + 1 < count; ++k) {
    const Vec3& b = corners[ring[(apex + k) % count]];
    const Vec3& c = corners[ring[(apex + k + 1) % count]];
    smallest = std::min(smallest, Dot(normal, Cross(b - a, c - a)));
  }
  return smallest;
}

std::optional<std::size_t> FindApex(std::span<const Vec3> corners, const Ring& ring) {
  if (ring.size() < 4) return 0;
  Vec3 normal;
  const Vec3& origin = corners[ring[0]];
  for (std::size_t k = 1; k + 1 < ring.size(); ++k) {
    normal += Cross(corners[ring[k]] - origin, corners[ring[k + 1]] - origin);
  }
  const double length = Norm(normal);
  if (!(length > 0.0) || !std::isfinite(length)) return 0;
  normal = normal / length;
  const std::size_t tries = std::min(ring.size(), kMaxApexTries);
  // Collinear corners leave triangles of no area; rounding must not turn those into folds.
  const double slack = -1e-12 * length;
  std::optional<std::size_t> flat_apex;
  for (std::size_t apex = 0; apex < tries; ++apex) {
    const double smallest = SmallestSignedArea(corners, ring, apex, normal);
    if (smallest > -slack) return apex;
    if (smallest >= slack && !flat_apex) flat_apex = apex;
  }
  return flat_apex;
}

/// The distinct corners (f, k) of `count` triangles, ascending, and the triangles as indices into
/// them.
template <class CornerOf>
auto IndexedCorners(std::size_t count, const CornerOf& corner) {
  std::vector<decltype(corner(0, 0))> distinct;
  distinct.reserve(count * 3);
  for (std::size_t f = 0; f < count; ++f) {
    for (std::size_t k = 0; k < 3; ++k) distinct.push_back(corner(f, k));
  }
  std::ranges::sort(distinct);
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  std::vector<Triangle> triangles(count);
  for (std::size_t f = 0; f < count; ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto place = std::ranges::lower_bound(distinct, corner(f, k));
      triangles[f][k] = static_cast<std::int32_t>(place - distinct.begin());
    }
  }
  return std::pair(std::move(distinct), std::move(triangles));
}

/// Merges equal colours at the same welded position and drops unused ones, in the order of the
/// positions.
void WeldColors(Mesh& mesh) {
  // A position and the colour a triangle sees there.
  using Corner = std::tuple<std::int32_t, double, double, double>;
  const auto corner = [&mesh](std::size_t f, std::size_t k) {
    const Rgb& color = mesh.colors[static_cast<std::size_t>(mesh.color_triangles[f][k])];
    return Corner(mesh.triangles[f][k], color.r, color.g, color.b);
  };
  auto [distinct, triangles] = IndexedCorners(mesh.color_triangles.size(), corner);
  std::vector<Rgb> colors;
  colors.reserve(distinct.size());
  for (const auto& [position, r, g, b] : distinct) colors.push_back({r, g, b});
  mesh.colors = std::move(colors);
  mesh.color_triangles = std::move(triangles);
}

void CheckTriangles(const std::vector<Triangle>& triangles,
                    std::size_t num_triangles,
                    std::size_t num_values,
                    const char* kind) {
  const bool in_range =
      std::ranges::all_of(triangles, [&](const Triangle& t) { return IsInRange(t, num_values); });
  if (triangles.size() != num_triangles || !in_range) {
    throw SceneError(std::string("a mesh to be written has wrong ") + kind + " indices");
  }
}

void AppendTriangles(const SharedVector<Triangle>& from,
                     std::size_t offset,
                     SharedVector<Triangle>& to) {
  for (Triangle t : from) {
    for (std::int32_t& i : t) i += static_cast<std::int32_t>(offset);
    to.push_back(t);
  }
}

}  // namespace

std::optional<FanTriangles> TriangulatePolygon(std::span<const Vec3> corners) {
  Ring ring = DistinctCorners(corners);
  if (corners.size() <= 3 || ring.size() < 3) {
    ring.clear();
    for (std::size_t i = 0; i < corners.size(); ++i) ring.push_back(i);
  }
  const std::optional<std::size_t> apex = FindApex(corners, ring);
  if (!apex) return std::nullopt;
  FanTriangles triangles;
  const std::size_t count = ring.size();
  for (std::size_t k = 1; k + 1 < count; ++k) {
    triangles.push_back({ring[*apex], ring[(*apex + k) % count], ring[(*apex + k + 1) % count]});
  }
  return triangles;
}

void FinishMesh(Mesh& mesh) {
  WeldPositions(mesh);
  WeldColors(mesh);
  NormalizeVertexNormals(mesh);
}

void AppendMesh(const Mesh& other, Mesh& mesh) {
  const auto append =
      [](auto& values, auto& triangles, const auto& more, const auto& more_triangles) {
        if (triangles.empty() || more_triangles.empty()) {
          values.clear();
          triangles.clear();
          return;
        }
        AppendTriangles(more_triangles, values.size(), triangles);
        values.insert(values.end(), more.begin(), more.end());
      };
  append(mesh.normals, mesh.normal_triangles, other.normals, other.normal_triangles);
  append(mesh.uvs, mesh.uv_triangles, other.uvs, other.uv_triangles);
  append(mesh.colors, mesh.color_triangles, other.colors, other.color_triangles);
  AppendTriangles(other.triangles, mesh.positions.size(), mesh.triangles);
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
}

SplitMesh SplitVertices(const Mesh& mesh) {
  const bool normals = !mesh.normal_triangles.empty();
  const bool uvs = !mesh.uv_triangles.empty();
  const bool colors = !mesh.color_triangles.empty();
  const std::size_t count = mesh.triangles.size();
  CheckTriangles(mesh.triangles, count, mesh.positions.size(), "position");
  if (normals) CheckTriangles(mesh.normal_triangles, count, mesh.normals.size(), "normal");
  if (uvs) CheckTriangles(mesh.uv_triangles, count, mesh.uvs.size(), "uv");
  if (colors) CheckTriangles(mesh.color_triangles, count, mesh.colors.size(), "color");

  const auto corner = [&](std::size_t f, std::size_t k) {
    return SplitVertex{mesh.triangles[f][k],
                       normals ? mesh.normal_triangles[f][k] : -1,
                       uvs ? mesh.uv_triangles[f][k] : -1,
                       colors ? mesh.color_triangles[f][k] : -1};
  };
  auto [vertices, triangles] = IndexedCorners(count, corner);
  return {std::move(vertices), std::move(triangles)};
}

float StoredFloat(double value, const std::filesystem::path& path) {
  if (!(std::fabs(value) <= static_cast<double>(std::numeric_limits<float>::max()))) {
    throw IoError(path.string() +
                  ": the mesh holds a number that a file cannot store: " + std::to_string(value));
  }
  return static_cast<float>(value);
}

}  // namespace pathfit::renderer
