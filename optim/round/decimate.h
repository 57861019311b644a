#pragma once

#include "renderer/geometry/mesh.h"

namespace pathfit::optim {

/// The surface of `mesh` by at most `num_triangles` triangles where its shape allows it: edges are
/// collapsed, those first that lie farthest from no plane of what was there [Garland and Heckbert
/// 1997], none that turns a triangle over. Positions and triangles alone; borders stay as they are.
/// Same mesh, same bits. Precondition: ValidateMesh passed, num_triangles > 0. Fails: SceneError if
/// a vertex joins parts that share no edge there.
renderer::Mesh Decimate(const renderer::Mesh& mesh, int num_triangles);

}  // namespace pathfit::optim
