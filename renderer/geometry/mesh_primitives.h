#pragma once

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// [-1, 1]^2 in z = 0, normal +z.
Mesh MakeRectangle();

/// [-1, 1]^3, outward winding.
Mesh MakeCube();

}  // namespace pathfit::renderer
