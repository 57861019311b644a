#pragma once

#include <utility>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Pairs (i < j) of meshes in one frame that cut each other: an edge of one passes through the
/// inside of a triangle of the other and reaches deeper than kTouchDepth, in half diagonals of that
/// mesh, on both sides. Meshes that only touch do not.
std::vector<std::pair<int, int>> IntersectingMeshes(const std::vector<const Mesh*>& meshes);

inline constexpr double kTouchDepth = 1e-5;

}  // namespace pathfit::renderer
