#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// Triangles of one polygon as indices into its corners, wound as the polygon.
using FanTriangles = std::vector<std::array<std::size_t, 3>>;

/// Fan from the first corner that sees the whole polygon: corner 0 when it is convex. Corners of
/// polygons (not of triangles) that coincide with the one before count once. Degenerate polygons
/// are kept for ValidateMesh to name. Empty when no corner sees the whole polygon.
std::optional<FanTriangles> TriangulatePolygon(std::span<const Vec3> corners);

}  // namespace pathfit::renderer
