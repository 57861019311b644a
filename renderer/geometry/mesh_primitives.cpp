#include "renderer/geometry/mesh_primitives.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include "renderer/core/error.h"

namespace pathfit::renderer {
namespace {

/// What is right and up of the picture on the side of a box that faces along `normal`.
std::pair<Vec3, Vec3> BoxSide(const Vec3& normal) {
  const double x = std::abs(normal.x), y = std::abs(normal.y), z = std::abs(normal.z);
  if (y >= x && y >= z) {
    const double sign = normal.y > 0.0 ? 1.0 : -1.0;
    return {{1.0, 0.0, 0.0}, {0.0, 0.0, -sign}};
  }
  const Vec3 up{0.0, 1.0, 0.0};
  if (z >= x) return {{normal.z > 0.0 ? 1.0 : -1.0, 0.0, 0.0}, up};
  return {{0.0, 0.0, normal.x > 0.0 ? -1.0 : 1.0}, up};
}

/// UVs of the corners of one triangle on a globe; those of a pole and those beyond the date line
/// follow the others.
std::array<Vec2, 3> GlobeUvs(const std::array<Vec3, 3>& corners) {
  constexpr double kPole = 1e-12;
  std::array<Vec2, 3> uvs;
  std::array<bool, 3> is_pole{};
  double largest = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 p = Normalized(corners[k]);
    is_pole[k] = std::hypot(p.x, p.z) < kPole;
    uvs[k] = {0.5 + std::atan2(p.x, p.z) / (2.0 * std::numbers::pi),
              std::acos(std::clamp(-p.y, -1.0, 1.0)) / std::numbers::pi};
    if (!is_pole[k]) largest = std::max(largest, uvs[k].x);
  }
  double sum = 0.0, count = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (is_pole[k]) continue;
    if (largest - uvs[k].x > 0.5) uvs[k].x += 1.0;
    sum += uvs[k].x;
    count += 1.0;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (is_pole[k] && count > 0.0) uvs[k].x = sum / count;
  }
  return uvs;
}

/// Gives the corners of every triangle the UVs of `uvs_of`, equal ones of a position once.
template <class UvsOf>
void SetUvs(const UvsOf& uvs_of, Mesh& mesh) {
  std::map<std::array<double, 3>, std::int32_t> known;  // position, u, v
  mesh.uvs.clear();
  mesh.uv_triangles.clear();
  for (const Triangle& triangle : mesh.triangles) {
    std::array<Vec3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = mesh.positions[static_cast<std::size_t>(triangle[k])];
    }
    const std::array<Vec2, 3> uvs = uvs_of(corners);
    Triangle& indices = mesh.uv_triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [entry, is_new] =
          known.try_emplace({static_cast<double>(triangle[k]), uvs[k].x, uvs[k].y},
                            static_cast<std::int32_t>(mesh.uvs.size()));
      if (is_new) mesh.uvs.push_back(uvs[k]);
      indices[k] = entry->second;
    }
  }
}

}  // namespace

Mesh MakeRectangle() {
  Mesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.uv_triangles = mesh.triangles;
  return mesh;
}

Mesh MakeCube() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back(
        {(i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0, (i & 4) != 0 ? 1.0 : -1.0});
  }
  mesh.triangles = {{0, 2, 3},
                    {0, 3, 1},
                    {4, 5, 7},
                    {4, 7, 6},
                    {0, 1, 5},
                    {0, 5, 4},
                    {2, 6, 7},
                    {2, 7, 3},
                    {0, 4, 6},
                    {0, 6, 2},
                    {1, 3, 7},
                    {1, 7, 5}};
  return mesh;
}

Mesh MakeDisk(int segments) {
  if (segments < 3) {
    throw SceneError("a disk needs at least 3 segments, not " + std::to_string(segments));
  }
  Mesh mesh;
  for (std::int32_t i = 0; i < segments; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / segments;
    mesh.positions.push_back({std::cos(angle), std::sin(angle), 0.0});
    mesh.triangles.push_back({segments, i, (i + 1) % segments});
  }
  mesh.positions.push_back({0.0, 0.0, 0.0});
  for (const Vec3& p : mesh.positions) {
    mesh.uvs.push_back({0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y});
  }
  mesh.uv_triangles = mesh.triangles;
  return mesh;
}

void SetBoxUvs(Mesh& mesh) {
  SetUvs(
      [](const std::array<Vec3, 3>& p) {
        const auto [right, up] = BoxSide(Cross(p[1] - p[0], p[2] - p[0]));
        std::array<Vec2, 3> uvs;
        for (std::size_t k = 0; k < 3; ++k) {
          uvs[k] = {0.5 + 0.5 * Dot(p[k], right), 0.5 + 0.5 * Dot(p[k], up)};
        }
        return uvs;
      },
      mesh);
}

void SetSphereUvs(Mesh& mesh) { SetUvs(GlobeUvs, mesh); }

}  // namespace pathfit::renderer
