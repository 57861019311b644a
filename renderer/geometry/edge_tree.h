#pragma once

#include <vector>

#include "renderer/geometry/boundary_edge.h"
#include "renderer/geometry/edge_node.h"
#include "renderer/math/distribution_1d.h"

namespace pathfit::renderer {

/// Hierarchy over edges that draws those which can be silhouettes as seen from a point or along a
/// direction. A node holds a bounding sphere and bounds of its faces' normals and planes; it is
/// skipped if all its faces look to one side. Its leaves test each edge. Follows [Sander2000],
/// [Li2018] in spirit.
class EdgeTree {
 public:
  EdgeTree() = default;
  /// Puts the edges in the order of the tree, in which neighbours are close.
  explicit EdgeTree(std::vector<BoundaryEdge> edges);

  struct Pick {
    int edge = -1;             ///< into edges(); -1: none found
    double probability = 0.0;  ///< of this edge
    double remainder = 0.0;    ///< u rescaled to [0, 1) inside the pick
  };
  /// Draws an edge; every silhouette edge has a positive probability, roughly proportional to
  /// weight * length / distance^2 (`by_distance`) or weight * length. Probabilities sum to less
  /// than one where a node was entered in vain; monotone in u over the order of edges().
  [[nodiscard]] Pick SampleFromPoint(const Vec3& y, bool by_distance, double u) const;
  [[nodiscard]] Pick SampleAlongDirection(const Vec3& w, double u) const;
  /// Draws an edge with probability proportional to weight * length * (angle between its faces'
  /// normals; pi for a border): uniform over lines, with the wedge sampling of tangent_wedge.h.
  [[nodiscard]] Pick SampleByWedge(double u) const;

  [[nodiscard]] const std::vector<BoundaryEdge>& edges() const { return tree_.edges; }
  /// WedgeAngle of one of them.
  [[nodiscard]] double Wedge(int edge) const {
    return tree_.wedges[static_cast<std::size_t>(edge)];
  }
  [[nodiscard]] bool Empty() const { return tree_.edges.empty(); }
  /// Sum of weight * length * wedge angle: SampleByWedge and the wedge's density give
  /// 1 / (4 * WedgeTotal) per metre and steradian, times weight.
  [[nodiscard]] double WedgeTotal() const { return by_wedge_.Total(); }

 private:
  EdgeHierarchy tree_;
  Distribution1D by_wedge_;
};

}  // namespace pathfit::renderer
