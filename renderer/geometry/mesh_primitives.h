#pragma once

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// [-1, 1]^2 in z = 0, normal +z; the UVs run from (0, 0) at (-1, -1) to (1, 1), u along x.
Mesh MakeRectangle();

/// [-1, 1]^3, outward winding, no UVs.
Mesh MakeCube();

/// Unit circle's regular polygon in z = 0 about the origin, normal +z, `segments` corners from +x;
/// UVs as for the rectangle around it. Fails: SceneError below 3 segments.
Mesh MakeDisk(int segments);

/// UVs of a box about the origin: all of (0, 0) to (1, 1) on each side of [-1, 1]^3, upright as
/// seen from outside (+y up; of the top -z is up, of the bottom +z).
void SetBoxUvs(Mesh& mesh);

/// UVs of a globe about the origin: u runs eastwards about +y and is 1/2 towards +z, v is 0 at the
/// south pole (-y) and 1 at the north pole. Triangles over the date line have u above 1.
void SetSphereUvs(Mesh& mesh);

}  // namespace pathfit::renderer
