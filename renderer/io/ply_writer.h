#pragma once

#include <filesystem>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Binary little endian PLY: x y z, and nx ny nz and s t when the mesh has them, as float; colours
/// as sRGB encoded uchar, clamped to 0..1. Positions are repeated where other attributes differ.
/// Written through a temporary file. Fails: IoError (not writable, a number beyond float),
/// SceneError (wrong indices).
void WritePly(const std::filesystem::path& path, const Mesh& mesh);

}  // namespace pathfit::renderer
