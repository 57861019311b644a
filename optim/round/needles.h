#pragma once

#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::optim {

/// Marks vertices that stand out of the surface around them like the point of a needle: their
/// triangles look to all sides, so that their areas cancel. A ridge, however sharp, is none, since
/// its triangles look to two sides, nor is the corner of a box. One triangle wide, it is nothing
/// that photos of this mesh's level can show: noise of steps grows such points, and what they have
/// folded between them no later step opens.
std::vector<char> FindNeedles(const renderer::Mesh& mesh);

/// Pulls needles, and some of their surroundings the longer that takes, to the middle of their
/// neighbours. False: there are none.
bool SmoothNeedles(renderer::Mesh& mesh);

}  // namespace pathfit::optim
