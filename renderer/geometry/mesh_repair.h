#pragma once

#include <string>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// What RepairMesh has done; all zero for a mesh that was in order.
struct MeshRepairs {
  int merged_positions = 0;      ///< bit-equal to another one
  int unused_positions = 0;      ///< dropped
  int replaced_normals = 0;      ///< of length zero
  int degenerate_triangles = 0;  ///< dropped: a repeated corner or no area
  int duplicate_triangles = 0;   ///< dropped: the corners of an earlier one, in any order
  int folded_triangles = 0;      ///< dropped in pairs of opposite winding
  int turned_triangles = 0;      ///< winding reversed
  int cut_edges = 0;             ///< edges with more than two triangles
  int added_positions = 0;       ///< where sheets were cut apart

  friend bool operator==(const MeshRepairs&, const MeshRepairs&) = default;
};

/// Such as "2 triangles without area dropped, 1 edge with more than two triangles cut"; empty when
/// nothing was done.
std::string Describe(const MeshRepairs& repairs);

/// A mesh that ValidateMesh accepts. In this order:
/// - bit-equal positions are merged, unused ones dropped; normals become unit, those of length zero
///   the smooth ones of their positions;
/// - degenerate triangles are dropped (where a sliver without area joined two long edges, these
///   become borders that coincide);
/// - of triangles with the same three corners only the first stays; none of them, if they are two
/// of
///   opposite winding folded onto each other beside a surface that closes without them;
/// - windings are made to agree across edges with two triangles; each connected surface keeps the
///   winding that most of its triangles have (its first triangle's in a tie);
/// - edges with more than two triangles are cut into sheets (see CornerFans): all but the first
///   sheet at a vertex get their own position there, moved by kCutGap of the way to the sheet's
///   middle, since borders that coincide would count a visibility jump twice.
/// UVs, normals and colours stay with their corners. Fails: SceneError naming `name` for what
/// cannot be mended: numbers that are not finite, indices out of range, no triangle left, a surface
/// with one side only (Moebius strip), a single edge of more than two triangles whose sheets hang
/// together around both ends.
Mesh RepairMesh(Mesh mesh, const std::string& name, MeshRepairs* repairs = nullptr);

inline constexpr double kCutGap = 1e-4;

}  // namespace pathfit::renderer
