#include "renderer/io/split_vertices.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

#include "renderer/core/error.h"

namespace pathfit::renderer {
namespace {

std::size_t Index(std::int32_t i) { return static_cast<std::size_t>(i); }

void CheckTriangles(const std::vector<Triangle>& triangles,
                    std::size_t num_triangles,
                    std::size_t num_values,
                    const char* kind) {
  const bool in_range = std::all_of(triangles.begin(), triangles.end(), [&](const Triangle& t) {
    return std::all_of(
        t.begin(), t.end(), [&](std::int32_t i) { return i >= 0 && Index(i) < num_values; });
  });
  if (triangles.size() != num_triangles || !in_range) {
    throw SceneError(std::string("a mesh to be written has wrong ") + kind + " indices");
  }
}

}  // namespace

SplitMesh SplitVertices(const Mesh& mesh, const SplitAttributes& wanted) {
  const bool normals = wanted.normals && !mesh.normal_triangles.empty();
  const bool uvs = wanted.uvs && !mesh.uv_triangles.empty();
  const bool colors = wanted.colors && !mesh.color_triangles.empty();
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
  SplitMesh split;
  split.vertices.reserve(count * 3);
  for (std::size_t f = 0; f < count; ++f) {
    for (std::size_t k = 0; k < 3; ++k) split.vertices.push_back(corner(f, k));
  }
  std::sort(split.vertices.begin(), split.vertices.end());
  split.vertices.erase(std::unique(split.vertices.begin(), split.vertices.end()),
                       split.vertices.end());
  split.triangles.resize(count);
  for (std::size_t f = 0; f < count; ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto place =
          std::lower_bound(split.vertices.begin(), split.vertices.end(), corner(f, k));
      split.triangles[f][k] = static_cast<std::int32_t>(place - split.vertices.begin());
    }
  }
  return split;
}

float StoredFloat(double value, const std::filesystem::path& path) {
  if (!(std::fabs(value) <= static_cast<double>(std::numeric_limits<float>::max()))) {
    throw IoError(path.string() +
                  ": the mesh holds a number that a file cannot store: " + std::to_string(value));
  }
  return static_cast<float>(value);
}

}  // namespace pathfit::renderer
