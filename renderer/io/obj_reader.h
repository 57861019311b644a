#pragma once

#include <filesystem>
#include <vector>

#include "renderer/geometry/mesh.h"
#include "renderer/io/mesh_file.h"

namespace pathfit::renderer {

/// Wavefront OBJ. Read: v x y z (w is ignored) or v x y z r g b (linear, for all vertices or none),
/// vt (v up), vn, f with every index form including negative. Polygons become fans. Groups,
/// materials, smoothing, lines and points are ignored. Positions are welded; uvs and normals stay
/// only if every face has them; normals become unit, those of length zero the smooth normals of
/// their positions. Fails: IoError with file:line for other statements, numbers that are not
/// finite, indices out of range.
Mesh ReadObj(const std::filesystem::path& path);

/// Like ReadObj, but one mesh for each `usemtl` name, in the order of their first faces; faces of
/// one name belong together wherever they stand.
std::vector<MeshGroup> ReadObjGroups(const std::filesystem::path& path);

}  // namespace pathfit::renderer
