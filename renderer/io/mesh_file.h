#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Triangles of a file that belong together by a name.
struct MeshGroup {
  std::string name;  ///< as in the file; empty for triangles that have none
  Mesh mesh;         ///< with its own positions
};

/// The formats that are read, for people: "OBJ or PLY".
std::string MeshFormatNames();

/// The mesh of a file: positions welded and within kMaxCoordinate, polygons cut into triangles,
/// normals unit. Its frame and unit are the file's. The extension tells the format, in either case.
/// The mesh may still be one that ValidateMesh refuses. Fails: IoError naming the file, and the
/// line or element where it has one: not readable, malformed, not finite, of another kind.
Mesh ReadMesh(const std::filesystem::path& path);

/// Like ReadMesh, one mesh for each name. A surface that is cut by this is open there: both parts
/// get borders at the same place. Fails: also when the format has no groups.
std::vector<MeshGroup> ReadMeshGroups(const std::filesystem::path& path);

}  // namespace pathfit::renderer
