#pragma once

#include <filesystem>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Wavefront OBJ. Read: v x y z (w is ignored) or v x y z r g b (linear, for all vertices or none),
/// vt, vn, f with every index form including negative. Polygons become fans. Groups, materials,
/// smoothing, lines and points are ignored. Positions are welded; uvs and normals stay only if
/// every face has them. Fails: IoError with file:line for other statements, numbers that are not
/// finite, indices out of range.
Mesh ReadObj(const std::filesystem::path& path);

}  // namespace pathfit::renderer
