#pragma once

#include <cstdint>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// What no surface of a body has. Counted on valid meshes.
struct MeshFolds {
  int folded_edges = 0;        ///< whose triangles' normals differ by more than kFoldAngle
  int crossing_triangles = 0;  ///< that pass through another one: CrossingTriangles
  [[nodiscard]] int Total() const { return folded_edges + crossing_triangles; }
  friend bool operator==(const MeshFolds&, const MeshFolds&) = default;
};
MeshFolds CountFolds(const Mesh& mesh);
/// Of folded edges and crossing ones, ascending.
std::vector<std::int32_t> FoldedTriangles(const Mesh& mesh);

inline constexpr double kFoldAngle = 150.0;  ///< degrees
/// Whether triangles with these normals, of any length, are folded onto each other.
bool AreFolded(const Vec3& n_a, const Vec3& n_b);

/// Triangles, ascending, that another one of the same connected part passes through: an edge of one
/// pierces the inside of the other. Neighbours that share an edge never do; parts that reach into
/// each other are how models are built. `parts`: MeshTopology::parts.
std::vector<std::int32_t> CrossingTriangles(const Mesh& mesh,
                                            const std::vector<std::int32_t>& parts);

/// Pulls the vertices of folds and crossings to the middle of their neighbours, and some of their
/// surroundings the longer that takes, until there are none or after kMaxUnfoldPasses. Vertices of
/// borders stay. Returns what is left: where some are, the mesh is that of the pass with the
/// fewest, since what does not unfold so would be smoothed away with all around it.
MeshFolds Unfold(Mesh& mesh);

inline constexpr int kMaxUnfoldPasses = 24;

/// Vertices at points one triangle wide: the areas around them, as vectors, cancel to less than
/// kNeedleShare of their sum (a cone of half the angle asin(kNeedleShare) has as much).
int CountNeedles(const Mesh& mesh);

inline constexpr double kNeedleShare = 0.55;

}  // namespace pathfit::renderer
