#pragma once

#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// How the surfaces of two meshes meet, i < j, or those of one, i = j: they touch at least.
struct MeshContact {
  int i = 0, j = 0;
  bool cut = false;
  bool overlap = false;
  bool folded = false;  ///< triangles that edges join touch
  friend bool operator==(const MeshContact&, const MeshContact&) = default;
};

/// Whence meshes are seen: a point, or, with w = 0, a direction towards the eye.
struct Eye {
  Vec3 at;
  double w = 1.0;
};

/// Contacts of meshes in one frame, each pair once, in ascending order. Surfaces cut each other
/// where an edge of one passes through the inside of a triangle of the other and reaches deeper
/// than kTouchDepth, in half diagonals of the smaller of the two meshes, on both sides. They
/// overlap where triangles lie in each other's plane, to that depth, cover each other, and one of
/// `eyes` is before them; not where the inside of a closed part that holds no eye is between: a
/// body hides what it stands on. They touch where an edge comes as near as that. Parts of one mesh
/// are what edges join. Joined triangles touch along inner edges alone, those at a corner of the
/// edge left out. Precondition: the meshes are valid.
std::vector<MeshContact> MeshContacts(const std::vector<const Mesh*>& meshes,
                                      const std::vector<Eye>& eyes);

inline constexpr double kTouchDepth = 1e-5;

}  // namespace pathfit::renderer
