#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "renderer/geometry/boundary_edge.h"

namespace pathfit::renderer {

/// Four subtrees side by side, so that they are tested together.
///
/// The faces of a subtree have planes n.(x - center) = o with |o| <= thickness and normals n =
/// normal + p + q + r, where p + q is a combination of the axes with both coefficients in [-1, 1]
/// and of squared norm at most squared_round, and |r| <= depth. So n.(y - x) over all faces and all
/// points x of their planes is normal.(y - center), up to the smaller of |u| + |v| and
/// sqrt(squared_round (u^2 + v^2)), plus depth |y - center| + thickness; u and v are the axes times
/// (y - center).
struct EdgeNode {
  static constexpr std::size_t kWidth = 4;
  template <class T>
  using Lanes = std::array<T, kWidth>;

  Lanes<double> x{}, y{}, z{};  ///< center of the bounding sphere
  std::array<Lanes<float>, 3> normal{};
  std::array<Lanes<float>, 3> axis1{}, axis2{};
  // Where there is no subtree: values that keep its importance a number, zero.
  Lanes<float> squared_round{}, depth{1, 1, 1, 1}, thickness{1, 1, 1, 1};
  Lanes<float> squared_radius{1, 1, 1, 1};
  Lanes<float> weight{};        ///< sum of weight * length, in units of the tree's; 0: no subtree
  Lanes<float> arcs{};          ///< the same times the angle between the normals
  Lanes<std::int32_t> child{};  ///< into the nodes, or ~index into the leaves
};

/// Eight edges side by side; positions and plane offsets are relative to the center of their leaf.
struct EdgeBlock {
  static constexpr std::size_t kWidth = 8;
  using Lanes = std::array<float, kWidth>;

  std::array<Lanes, 3> n0{}, n1{}, middle{};
  Lanes o0{}, o1{};      ///< n.(x - center) on the faces
  Lanes squared_half{};  ///< half the length, squared
  Lanes weight{};        ///< weight * length, 0 if there is no edge
};

struct EdgeLeaf {
  static constexpr std::size_t kMaxBlocks = 4;

  std::int32_t first_block = 0;
  std::int32_t num_blocks = 0;
  std::int32_t first_edge = 0;
  float slack = 0.0F;  ///< bound of rounding errors that do not grow with the distance
};

struct EdgeHierarchy {
  std::vector<BoundaryEdge> edges;  ///< in the order of the leaves
  std::vector<double> wedges;       ///< WedgeAngle of each
  std::vector<EdgeNode> nodes;      ///< nodes[0] is the root; none if no edge can be a silhouette
  std::vector<EdgeLeaf> leaves;
  std::vector<EdgeBlock> blocks;
};

/// Edges whose faces are parallel come last and into no leaf: they are never a silhouette.
EdgeHierarchy BuildEdgeHierarchy(std::vector<BoundaryEdge> edges);

}  // namespace pathfit::renderer
