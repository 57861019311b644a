#pragma once

#include <filesystem>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// STL, binary (little-endian) or as text; the size tells which. Positions are welded: the format
/// repeats them for each triangle. Ignored are normals, which the winding tells, names, the header
/// and colours in attribute bytes; the solids of a text become one mesh.
/// Fails: IoError with file:line of a text, or the triangle's number, counted from 1.
Mesh ReadStl(const std::filesystem::path& path);

}  // namespace pathfit::renderer
