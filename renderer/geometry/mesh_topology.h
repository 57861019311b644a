#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// An edge of the welded mesh with its one (border) or two faces. `faces[1]` is -1 at a border.
/// `vertices` are in the winding order of faces[0]; `apex[i]` is the vertex of faces[i] that is not
/// on the edge.
struct MeshEdge {
  std::array<std::int32_t, 2> vertices;
  std::array<std::int32_t, 2> faces;
  std::array<std::int32_t, 2> apex;
};

/// Edges, vertex neighbours and closedness of a mesh whose positions are welded.
struct MeshTopology {
  std::vector<MeshEdge> edges;
  std::vector<std::vector<std::int32_t>> neighbors;  ///< one ring of each vertex, ascending
  bool closed = false;                               ///< every edge has two faces
  bool solid = false;  ///< closed, and every connected piece wound outwards

  /// Precondition: ValidateMesh passed.
  static MeshTopology Build(const Mesh& mesh);
  /// For new positions: only `solid` depends on them.
  void UpdateSolid(const Mesh& mesh);
};

}  // namespace pathfit::renderer
