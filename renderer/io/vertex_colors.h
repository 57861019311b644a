#pragma once

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Merges equal colours at the same welded position and drops unused ones, in the order of the
/// positions: without colour seams, color_triangles becomes equal to triangles.
void WeldColors(Mesh& mesh);

}  // namespace pathfit::renderer
