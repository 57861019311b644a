#pragma once

#include <cstdint>
#include <filesystem>
#include <tuple>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// One vertex of a file format with a single index: indices into the mesh's arrays, -1 for an
/// absent attribute.
struct SplitVertex {
  std::int32_t position = -1;
  std::int32_t normal = -1;
  std::int32_t uv = -1;
  std::int32_t color = -1;
  friend bool operator==(const SplitVertex&, const SplitVertex&) = default;
  friend bool operator<(const SplitVertex& a, const SplitVertex& b) {
    return std::tie(a.position, a.normal, a.uv, a.color) <
           std::tie(b.position, b.normal, b.uv, b.color);
  }
};

struct SplitMesh {
  std::vector<SplitVertex> vertices;  ///< ascending: one per position keeps the positions' order
  std::vector<Triangle> triangles;    ///< indices into vertices
};

/// Which attributes, besides the position, tell vertices apart.
struct SplitAttributes {
  bool normals = false;
  bool uvs = false;
  bool colors = false;
};

/// Repeats a position where the wanted attributes differ between its triangles. Attributes the mesh
/// lacks are ignored. Fails: SceneError when indices are out of range or attribute triangles do not
/// match.
SplitMesh SplitVertices(const Mesh& mesh, const SplitAttributes& wanted);

/// `value` as float. Fails: IoError naming `path` when it is not finite or too large.
float StoredFloat(double value, const std::filesystem::path& path);

}  // namespace pathfit::renderer
