#include "renderer/geometry/mesh_normals.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <unordered_map>
#include <vector>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_checks.h"

namespace pathfit::renderer {
namespace {

/// Angle between two edges; zero if one of them is.
double AngleBetween(const Vec3& a, const Vec3& b) {
  return std::atan2(Norm(Cross(a, b)), Dot(a, b));
}

std::vector<Vec3> AngleWeightedNormals(const Mesh& mesh) {
  std::vector<Vec3> normals(mesh.positions.size());
  std::vector<Vec3> any_face(mesh.positions.size(), Vec3{0.0, 0.0, 1.0});
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const Triangle& triangle = mesh.triangles[f];
    if (!IsInRange(triangle, mesh.positions.size())) {
      throw SceneError("triangle " + std::to_string(f) + " has a position index out of range");
    }
    const Vec3 area = TwiceArea(mesh, triangle);
    const double length = Norm(area);
    if (!(length > 0.0) || !std::isfinite(length)) continue;
    const Vec3 normal = area / length;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& corner = mesh.positions[Index(triangle[k])];
      const double angle = AngleBetween(mesh.positions[Index(triangle[(k + 1) % 3])] - corner,
                                        mesh.positions[Index(triangle[(k + 2) % 3])] - corner);
      normals[Index(triangle[k])] += normal * angle;
      any_face[Index(triangle[k])] = normal;
    }
  }
  // Angles of opposed triangles cancel but for rounding.
  constexpr double kMinLength = 1e-12;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const double length = Norm(normals[i]);
    normals[i] = length > kMinLength ? normals[i] / length : any_face[i];
  }
  return normals;
}

/// The unit vector along v, or zero when there is none.
Vec3 UnitOrZero(const Vec3& v) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!IsFinite(v) || largest == 0.0) return {};
  // The square of a tiny or huge vector would leave the range.
  return Normalized(v / largest);
}

}  // namespace

void ComputeVertexNormals(Mesh& mesh) {
  mesh.normals = AngleWeightedNormals(mesh);
  mesh.normal_triangles = mesh.triangles;
}

void RemoveVertexNormals(Mesh& mesh) {
  mesh.normals.clear();
  mesh.normal_triangles.clear();
}

int NormalizeVertexNormals(Mesh& mesh) {
  bool has_bad = false;
  for (Vec3& normal : mesh.normals) {
    normal = UnitOrZero(normal);
    has_bad = has_bad || SquaredNorm(normal) == 0.0;
  }
  if (!has_bad) return 0;
  if (mesh.normal_triangles.size() != mesh.triangles.size()) {
    throw SceneError("a mesh has " + std::to_string(mesh.normal_triangles.size()) +
                     " normal triangles for " + std::to_string(mesh.triangles.size()) +
                     " triangles");
  }
  const std::vector<Vec3> smooth = AngleWeightedNormals(mesh);
  constexpr std::int32_t kNobody = -1;
  std::vector<std::int32_t> owner(mesh.normals.size(), kNobody);
  std::unordered_map<std::int32_t, std::int32_t> extra_of_position;
  for (std::size_t f = 0; f < mesh.normal_triangles.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      std::int32_t& normal = mesh.normal_triangles[f][k];
      if (normal < 0 || Index(normal) >= owner.size() ||
          SquaredNorm(mesh.normals[Index(normal)]) > 0.0) {
        continue;
      }
      // A bad normal becomes that of the first position where it stands; others get new ones.
      const std::int32_t position = mesh.triangles[f][k];
      if (owner[Index(normal)] == kNobody) owner[Index(normal)] = position;
      if (owner[Index(normal)] == position) continue;
      const auto [entry, is_new] =
          extra_of_position.try_emplace(position, static_cast<std::int32_t>(mesh.normals.size()));
      if (is_new) mesh.normals.push_back(smooth[Index(position)]);
      normal = entry->second;
    }
  }
  int num_replaced = 0;
  for (std::size_t i = 0; i < owner.size(); ++i) {
    if (owner[i] == kNobody) continue;
    mesh.normals[i] = smooth[Index(owner[i])];
    ++num_replaced;
  }
  return num_replaced;
}

double MeanShadingDeviation(const Mesh& mesh) {
  double sum = 0.0;
  double area = 0.0;
  for (std::size_t f = 0; f < mesh.normal_triangles.size(); ++f) {
    const Triangle& t = mesh.triangles[f];
    const auto p = [&](std::size_t i) { return mesh.positions[Index(t[i])]; };
    const Vec3 twice_area = Cross(p(1) - p(0), p(2) - p(0));
    const auto cosine = [&](std::int32_t corner) {
      const Vec3& normal = mesh.normals[Index(corner)];
      return Dot(twice_area, normal) / Norm(normal);
    };
    const Triangle& corners = mesh.normal_triangles[f];
    const auto farthest = std::min_element(
        corners.begin(), corners.end(), [&](auto i, auto k) { return cosine(i) < cosine(k); });
    sum += AngleBetween(twice_area, mesh.normals[Index(*farthest)]) * Norm(twice_area);
    area += Norm(twice_area);
  }
  return area > 0.0 ? sum / area : 0.0;
}

}  // namespace pathfit::renderer
