#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// An edge of the welded mesh with its one (border) or two faces. `faces[1]` is -1 at a border.
/// `vertices` are in the winding order of faces[0]; `apex[i]` is the vertex of faces[i] that is not
/// on the edge.
struct MeshEdge {
  std::array<std::int32_t, 2> vertices;
  std::array<std::int32_t, 2> faces;
  std::array<std::int32_t, 2> apex;
};

/// Edges, parts and closedness of a mesh whose positions are welded.
struct MeshTopology {
  std::vector<MeshEdge> edges;
  std::vector<std::int32_t> parts;  ///< by triangle: number of its part, joined by edges
  bool closed = false;              ///< every edge has two faces
  bool solid = false;               ///< closed, and every connected piece wound outwards

  /// Precondition: ValidateMesh passed.
  static MeshTopology Build(const Mesh& mesh);
  /// For new positions: only `solid` depends on them.
  void UpdateSolid(const Mesh& mesh);
  [[nodiscard]] double MeanEdgeLength(const Mesh& mesh) const;
  /// One ring of each vertex, ascending.
  [[nodiscard]] std::vector<std::vector<std::int32_t>> Neighbors(const Mesh& mesh) const;
  /// Also marks the neighbours of the vertices that are marked.
  void MarkRing(std::vector<char>& marks) const;
  /// The three edges of each triangle.
  [[nodiscard]] std::vector<std::array<std::int32_t, 3>> EdgesOfTriangles() const;
};

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

/// Disjoint sets of integers.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) {
    parent_.reserve(count);
    while (parent_.size() < count) parent_.push_back(parent_.size());
  }
  std::size_t Find(std::size_t i) {
    while (parent_[i] != i) {
      parent_[i] = parent_[parent_[i]];
      i = parent_[i];
    }
    return i;
  }
  /// The smaller number stands for the union, so results do not depend on the order.
  void Unite(std::size_t a, std::size_t b) {
    a = Find(a);
    b = Find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace pathfit::renderer
