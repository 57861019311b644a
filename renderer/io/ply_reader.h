#pragma once

#include <filesystem>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// PLY in ascii and both binary orders. Read from `vertex`: x y z, nx ny nz (float or double), red
/// green blue (uchar is sRGB encoded and becomes linear; float and double are linear already), s t
/// or u v; from `face`: vertex_indices or vertex_index of any integer type. Polygons become fans,
/// everything else is skipped, positions are welded; normals become unit, those of length zero the
/// smooth normals of their positions. Fails: IoError naming the file and the line or
/// element; sizes are checked against the file before allocating.
Mesh ReadPly(const std::filesystem::path& path);

}  // namespace pathfit::renderer
