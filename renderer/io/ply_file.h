#pragma once

#include <filesystem>
#include <string>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// PLY in ascii and both binary orders. Read from `vertex`: x y z, nx ny nz (float or double), red
/// green blue (uchar is sRGB encoded and becomes linear; float and double are linear already), s t
/// or u v; from `face`: vertex_indices or vertex_index of any integer type. Polygons become fans,
/// everything else is skipped, positions are welded; normals become unit, those of length zero the
/// smooth normals of their positions. Fails: IoError naming the file and the line or
/// element; sizes are checked against the file before allocating.
Mesh ReadPly(const std::filesystem::path& path);

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
