#pragma once

#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// Two meshes, i < j, that cut each other or only touch.
struct MeshContact {
  int i = 0, j = 0;
  bool cut = false;
  friend bool operator==(const MeshContact&, const MeshContact&) = default;
};

/// Contacts of meshes in one frame, each pair once. They cut each other where an edge of one passes
/// through the inside of a triangle of the other and reaches deeper than kTouchDepth, in half
/// diagonals of the smaller of the two, on both sides; they touch where an edge comes as near as
/// that.
std::vector<MeshContact> MeshContacts(const std::vector<const Mesh*>& meshes);

inline constexpr double kTouchDepth = 1e-5;

}  // namespace pathfit::renderer
