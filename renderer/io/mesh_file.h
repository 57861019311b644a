#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Triangles of a file that belong together by a name.
struct MeshGroup {
  std::string name;  ///< as in the file; empty for triangles that have none
  Mesh mesh;         ///< with its own positions
};

/// A kind of mesh file. A new one is a reader, its row in mesh_file.cpp and its source in CMake.
struct MeshFormat {
  std::string_view name;       ///< such as "OBJ"
  std::string_view extension;  ///< with its dot, in small letters
  Mesh (*read)(const std::filesystem::path&);
  /// Null when files of this kind hold no groups. In the order of their first triangles.
  std::vector<MeshGroup> (*read_groups)(const std::filesystem::path&);
};
std::span<const MeshFormat> MeshFormats();

/// The mesh of a file: positions welded and within kMaxCoordinate, polygons cut into triangles,
/// normals unit. Its frame and unit are the file's. The extension tells the format, in either case.
/// The mesh may still be one that ValidateMesh refuses. Fails: IoError naming the file, and the
/// line or element where it has one: not readable, malformed, not finite, of another kind.
Mesh ReadMesh(const std::filesystem::path& path);

/// Like ReadMesh, one mesh for each name. A surface that is cut by this is open there: both parts
/// get borders at the same place. Fails: also when the format has no groups.
std::vector<MeshGroup> ReadMeshGroups(const std::filesystem::path& path);

}  // namespace pathfit::renderer
