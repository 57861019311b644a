#pragma once

#include <cstdint>
#include <vector>

#include "renderer/geometry/mesh.h"
#include "renderer/geometry/uv_overlap.h"

namespace pathfit::renderer {

/// A piece of a surface laid flat: its triangles and where their corners lie, in metres, the lower
/// left corner of all at the origin. No triangle is turned over or lies over another. Lengths are
/// those of a projection, scaled so that the areas' sum is the surface's.
struct UvChart {
  std::vector<std::int32_t> triangles;
  std::vector<FlatTriangle> corners;  ///< by triangle, counter-clockwise
  Vec2 size;
};

/// Cuts a surface into charts: triangles join as long as their normals agree well enough, the best
/// first and what has short borders [Garland et al. 2001, hierarchical face clustering], each piece
/// is projected along its mean normal, and what would be turned over, seen at a flat angle or come
/// to lie over something becomes another chart. Same mesh, same charts. Precondition: ValidateMesh
/// passed.
std::vector<UvChart> MakeUvCharts(const Mesh& mesh);

}  // namespace pathfit::renderer
