#pragma once

#include <filesystem>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// ReadObj or ReadPly by the extension, in either case. Fails: IoError naming what is allowed.
Mesh ReadMesh(const std::filesystem::path& path);

}  // namespace pathfit::renderer
