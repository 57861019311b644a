#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/scene/scene.h"

namespace pathfit::renderer {

/// Triangles of a file that belong together by a name.
struct MeshGroup {
  std::string name;  ///< as in the file; empty for triangles that have none
  Mesh mesh;         ///< with its own positions
};

/// What a file shows that may hold more than meshes, as far as the renderer has it.
struct SceneFile {
  /// Names are the file's own, those of objects of one list are all different. Meshes are like
  /// those of ReadMesh.
  Scene scene;
  std::vector<std::string> warnings;  ///< what is in the file but not, or changed, in `scene`
  std::vector<std::filesystem::path> files;  ///< all that were read, the file itself first
};

/// The formats that are read, for people: "OBJ, PLY, STL or glTF".
std::string MeshFormatNames();

/// The mesh of a file: positions welded and within kMaxCoordinate, polygons cut into triangles,
/// normals unit. Its frame and unit are the file's. The extension tells the format, in either case.
/// The meshes of a scene become one, in the scene's frame.
/// The mesh may still be one that ValidateMesh refuses. Fails: IoError naming the file, and the
/// line or element where it has one: not readable, malformed, not finite, of another kind.
Mesh ReadMesh(const std::filesystem::path& path);

/// Like ReadMesh, one mesh for each name. A surface that is cut by this is open there: both parts
/// get borders at the same place. Fails: also when the format has no groups.
std::vector<MeshGroup> ReadMeshGroups(const std::filesystem::path& path);

/// Whether files of this kind, by the extension, may hold more than meshes. False for other files.
bool HoldsScene(const std::filesystem::path& path);

/// What conventions the file's format adds: its reader's header. Precondition: HoldsScene. Fails:
/// IoError as ReadMesh.
SceneFile ReadSceneFile(const std::filesystem::path& path);

}  // namespace pathfit::renderer
