#pragma once

#include <filesystem>
#include <string>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Binary little endian PLY: x y z, and nx ny nz and s t when the mesh has them, as float; colours
/// as sRGB encoded uchar, clamped to 0..1. Positions are repeated where other attributes differ.
/// `texture_file`: name of an image beside the file that s t refer to (t up), said in a comment
/// "TextureFile" as MeshLab and others read it; empty: none.
/// Written through a temporary file. Fails: IoError (not writable, a number beyond float),
/// SceneError (wrong indices).
void WritePly(const std::filesystem::path& path,
              const Mesh& mesh,
              const std::string& texture_file = "");

}  // namespace pathfit::renderer
