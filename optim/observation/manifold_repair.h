#pragma once

#include "renderer/geometry/mesh.h"

namespace pathfit::optim {

/// Cuts a closed surface where it touches itself, at edges with more than two triangles and at
/// vertices with several fans, such that each piece of the body keeps its own edge and vertex; the
/// copies are moved `inset` (world units) into the body. Afterwards each edge has two triangles of
/// opposite direction. Throws SceneError if the surface is not closed or not consistently wound.
/// Positions and triangles only.
void SeparateTouchingParts(double inset, renderer::Mesh& mesh);

/// Keeps the part of largest enclosed volume, and its positions only.
void KeepLargestPart(renderer::Mesh& mesh);

}  // namespace pathfit::optim
