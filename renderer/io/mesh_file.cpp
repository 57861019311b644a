#include "renderer/io/mesh_file.h"

#include <algorithm>
#include <cctype>
#include <string>

#include "renderer/core/error.h"
#include "renderer/io/obj_reader.h"
#include "renderer/io/ply_reader.h"

namespace pathfit::renderer {

Mesh ReadMesh(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  if (extension == ".obj") return ReadObj(path);
  if (extension == ".ply") return ReadPly(path);
  throw IoError(path.string() + ": unknown kind of mesh file, allowed are .obj and .ply");
}

}  // namespace pathfit::renderer
