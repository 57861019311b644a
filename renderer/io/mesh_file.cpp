#include "renderer/io/mesh_file.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "renderer/core/error.h"
#include "renderer/core/lower_case.h"
#include "renderer/io/obj_reader.h"
#include "renderer/io/ply_file.h"

namespace pathfit::renderer {
namespace {

/// A kind of mesh file. A new one is a reader, its row here and its source in CMake.
struct MeshFormat {
  std::string_view name;       ///< such as "OBJ"
  std::string_view extension;  ///< with its dot, in small letters
  Mesh (*read)(const std::filesystem::path&);
  /// Null when files of this kind hold no groups. In the order of their first triangles.
  std::vector<MeshGroup> (*read_groups)(const std::filesystem::path&);
};

constexpr std::array<MeshFormat, 2> kFormats = {
    {{"OBJ", ".obj", ReadObj, ReadObjGroups}, {"PLY", ".ply", ReadPly, nullptr}}};

std::string Extensions(bool with_groups) {
  std::string text;
  for (const MeshFormat& format : kFormats) {
    if (with_groups && format.read_groups == nullptr) continue;
    text += (text.empty() ? "" : ", ") + std::string(format.extension);
  }
  return text;
}

const MeshFormat& FormatOf(const std::filesystem::path& path) {
  const std::string extension = LowerCase(path.extension().string());
  const auto format =
      std::ranges::find_if(kFormats, [&](const MeshFormat& f) { return f.extension == extension; });
  if (format == kFormats.end()) {
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

}  // namespace pathfit::renderer
