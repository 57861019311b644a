#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Sheets of triangles around each vertex: corners of triangles that are neighbours across an edge
/// belong to one fan. Across an edge with two triangles these are neighbours if their windings
/// agree. Around an edge with more, those that bound the same wedge of the body (its inside is
/// where the winding says) are neighbours if the edge is alternately entered and left by bodies;
/// otherwise the pairs of opposite direction that continue each other most smoothly.
struct CornerFans {
  std::vector<std::size_t> fan;  ///< of corner k of triangle f, at 3 f + k: its smallest corner
  /// Undirected edges (low, high) with more than two triangles, ascending.
  std::vector<std::pair<std::int32_t, std::int32_t>> non_manifold_edges;
  std::size_t num_irregular = 0;  ///< those of them that bodies do not enter and leave in turn
  std::size_t num_unpaired = 0;   ///< sides of triangles without neighbour

  /// Precondition: indices in range, no repeated vertex in a triangle.
  static CornerFans Build(const Mesh& mesh);
};

}  // namespace pathfit::renderer
