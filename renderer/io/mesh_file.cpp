#include "renderer/io/mesh_file.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "renderer/core/error.h"
#include "renderer/io/obj_reader.h"
#include "renderer/io/ply_file.h"

namespace pathfit::renderer {
namespace {

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
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  const auto format = std::find_if(kFormats.begin(), kFormats.end(), [&](const MeshFormat& f) {
    return f.extension == extension;
  });
  if (format == kFormats.end()) {
    throw IoError(path.string() + ": unknown kind of mesh file; allowed are " + Extensions(false));
  }
  return *format;
}

}  // namespace

std::span<const MeshFormat> MeshFormats() { return kFormats; }

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
