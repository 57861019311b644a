#include "renderer/io/mesh_file.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "renderer/core/error.h"
#include "renderer/core/lower_case.h"
#include "renderer/io/gltf_reader.h"
#include "renderer/io/mesh_assembly.h"
#include "renderer/io/obj_reader.h"
#include "renderer/io/ply_file.h"
#include "renderer/io/stl_reader.h"

namespace pathfit::renderer {
namespace {

/// A kind of mesh file. A new one is a reader, its row here and its source in CMake.
struct MeshFormat {
  std::string_view name;                       ///< such as "OBJ"
  std::array<std::string_view, 2> extensions;  ///< with dots, in small letters; may be the same
  Mesh (*read)(const std::filesystem::path&);
  /// Null when files of this kind hold no groups. In the order of their first triangles.
  std::vector<MeshGroup> (*read_groups)(const std::filesystem::path&);
  /// Null when files of this kind hold nothing but meshes.
  SceneFile (*read_scene)(const std::filesystem::path&);
};

Mesh ReadGltfMesh(const std::filesystem::path& path) {
  const std::vector<SceneMesh> meshes = ReadGltf(path).scene.meshes;
  if (meshes.empty()) throw IoError(path.string() + ": no triangles");
  Mesh mesh = meshes.front().mesh;
  std::for_each(
      meshes.begin() + 1, meshes.end(), [&](const SceneMesh& m) { AppendMesh(m.mesh, mesh); });
  FinishMesh(mesh);
  return mesh;
}

constexpr std::array<MeshFormat, 4> kFormats = {
    {{"OBJ", {".obj", ".obj"}, ReadObj, ReadObjGroups, nullptr},
     {"PLY", {".ply", ".ply"}, ReadPly, nullptr, nullptr},
     {"STL", {".stl", ".stl"}, ReadStl, nullptr, nullptr},
     {"glTF", {".gltf", ".glb"}, ReadGltfMesh, nullptr, ReadGltf}}};

std::string Extensions(bool with_groups) {
  std::string text;
  for (const MeshFormat& format : kFormats) {
    if (with_groups && format.read_groups == nullptr) continue;
    for (std::size_t i = 0; i < 2; ++i) {
      if (i == 1 && format.extensions[1] == format.extensions[0]) continue;
      text += (text.empty() ? "" : ", ") + std::string(format.extensions[i]);
    }
  }
  return text;
}

const MeshFormat* FindFormat(const std::filesystem::path& path) {
  const std::string extension = LowerCase(path.extension().string());
  const auto* format = std::ranges::find_if(kFormats, [&](const MeshFormat& f) {
    return std::ranges::find(f.extensions, extension) != f.extensions.end();
  });
  return format == kFormats.end() ? nullptr : format;
}

const MeshFormat& FormatOf(const std::filesystem::path& path) {
  const MeshFormat* format = FindFormat(path);
  if (format == nullptr) {
    throw IoError(path.string() + ": unknown kind of mesh file; allowed are " + Extensions(false));
  }
  return *format;
}

}  // namespace

std::string MeshFormatNames() {
  std::string text;
  for (const MeshFormat& format : kFormats) {
    const char* separator = text.empty() ? "" : &format == &kFormats.back() ? " or " : ", ";
    text += separator + std::string(format.name);
  }
  return text;
}

Mesh ReadMesh(const std::filesystem::path& path) { return FormatOf(path).read(path); }

std::vector<MeshGroup> ReadMeshGroups(const std::filesystem::path& path) {
  const MeshFormat& format = FormatOf(path);
  if (format.read_groups == nullptr) {
    throw IoError(path.string() + ": " + std::string(format.name) +
                  " files have no groups; files with groups are " + Extensions(true));
  }
  return format.read_groups(path);
}

bool HoldsScene(const std::filesystem::path& path) {
  const MeshFormat* format = FindFormat(path);
  return format != nullptr && format->read_scene != nullptr;
}

SceneFile ReadSceneFile(const std::filesystem::path& path) {
  return FormatOf(path).read_scene(path);
}

}  // namespace pathfit::renderer
