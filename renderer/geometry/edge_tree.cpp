#include "renderer/geometry/edge_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

namespace pathfit::renderer {
namespace {

// Rounding of single precision in n.(y - x), relative to |y - x|.
constexpr float kRounding = 1e-6F;
// Share of short arcs on the unit sphere that a great circle cuts, per radian of their length.
constexpr float kCrossing = 0.6366F;
// A node hardly touched may still hold a silhouette: square of the least share of its chord.
constexpr float kLeastSquaredChord = 0.01F;

// Unlike std::min and std::max, without a branch: the loops below become vector code.
float Lesser(float a, float b) { return a < b ? a : b; }
float Greater(float a, float b) { return a > b ? a : b; }

/// What the edges are seen from: target - x * place towards x.
struct View {
  Vec3 target;
  float place;  // 1: the target is a point, 0: a direction
};

template <class T, std::size_t N>
using Lanes = std::array<T, N>;

/// Importance of the four subtrees, and the view from their centers.
struct Children {
  std::array<Lanes<float, EdgeNode::kWidth>, 3> towards;
  Lanes<float, EdgeNode::kWidth> importance;
};

/// Estimates the length of silhouettes: an edge is one if the great circle across the view cuts the
/// arc between its two normals; these are taken to fill the node's ellipse evenly. 0 if no face can
/// look the other way than the rest.
template <bool by_distance>
void WeighChildren(const View& view, const EdgeNode& n, Children& out) {
  const auto place = static_cast<double>(view.place);
  for (std::size_t k = 0; k < EdgeNode::kWidth; ++k) {
    out.towards[0][k] = static_cast<float>(view.target.x - n.x[k] * place);
    out.towards[1][k] = static_cast<float>(view.target.y - n.y[k] * place);
    out.towards[2][k] = static_cast<float>(view.target.z - n.z[k] * place);
  }
  for (std::size_t k = 0; k < EdgeNode::kWidth; ++k) {
    const float x = out.towards[0][k];
    const float y = out.towards[1][k];
    const float z = out.towards[2][k];
    const float facing = std::abs(n.normal[0][k] * x + n.normal[1][k] * y + n.normal[2][k] * z);
    const float p = n.axis1[0][k] * x + n.axis1[1][k] * y + n.axis1[2][k] * z;
    const float q = n.axis2[0][k] * x + n.axis2[1][k] * y + n.axis2[2][k] * z;
    const float box = std::abs(p) + std::abs(q);
    const float ellipse = std::sqrt(n.squared_round[k] * (p * p + q * q));
    const float rest = n.depth[k] * (std::abs(x) + std::abs(y) + std::abs(z));
    const float reach = Lesser(box, ellipse) + rest + n.thickness[k] * view.place;
    const float beyond = facing / reach;
    const float chord = std::sqrt(Greater(kLeastSquaredChord, 1.0F - beyond * beyond));
    const float squared = Greater(x * x + y * y + z * z, n.squared_radius[k] * view.place);
    const float crossing = kCrossing * n.arcs[k] * chord * std::sqrt(squared) / reach;
    const float expected = Lesser(crossing, n.weight[k]);
    out.importance[k] = facing > reach ? 0.0F : (by_distance ? expected / squared : expected);
  }
}

using LeafImportance = std::array<float, EdgeLeaf::kMaxBlocks * EdgeBlock::kWidth>;

/// Importance of the eight edges: 0 if both faces surely look to the same side.
template <bool by_distance>
void WeighBlock(const View& view,
                const EdgeBlock& b,
                const Lanes<float, 3>& towards,
                float slack,
                float* importance) {
  const auto [dx, dy, dz] = towards;
  const float margin = kRounding * (std::abs(dx) + std::abs(dy) + std::abs(dz)) + slack;
  for (std::size_t k = 0; k < EdgeBlock::kWidth; ++k) {
    const float f0 = b.n0[0][k] * dx + b.n0[1][k] * dy + b.n0[2][k] * dz - b.o0[k] * view.place;
    const float f1 = b.n1[0][k] * dx + b.n1[1][k] * dy + b.n1[2][k] * dz - b.o1[k] * view.place;
    const float x = dx - b.middle[0][k];
    const float y = dy - b.middle[1][k];
    const float z = dz - b.middle[2][k];
    const float squared = Greater(x * x + y * y + z * z, b.squared_half[k]);
    const float value = by_distance ? b.weight[k] / squared : b.weight[k];
    const bool one_sided = (Lesser(f0, f1) > margin) | (Greater(f0, f1) < -margin);
    importance[k] = one_sided ? 0.0F : value;
  }
}

/// Chooses one of the values by their share; u becomes its place inside. -1 if all are 0.
int Choose(std::span<const float> values, double& u, double& probability) {
  double total = 0.0;
  for (const float value : values) {
    total += static_cast<double>(value);
  }
  if (!(total > 0.0) || !std::isfinite(total)) {
    return -1;
  }
  const double target = u * total;
  double below = 0.0;
  double start = 0.0;
  int chosen = -1;
  for (std::size_t k = 0; k < values.size() && (chosen < 0 || target >= below); ++k) {
    if (values[k] > 0.0F) {
      chosen = static_cast<int>(k);
      start = below;
      below += static_cast<double>(values[k]);
    }
  }
  const auto value = static_cast<double>(values[static_cast<std::size_t>(chosen)]);
  u = std::clamp((target - start) / value, 0.0, 1.0 - 0x1.0p-53);
  probability *= value / total;
  return chosen;
}

/// One way down the tree. A child counts as much as what is below it, one level or, for leaves,
/// their edges: few nodes are entered in vain.
template <bool by_distance>
class Descent {
 public:
  Descent(const EdgeHierarchy& tree, const View& view) : tree_(tree), view_(view) {}

  EdgeTree::Pick Run(double u) {
    double probability = 1.0;
    WeighChildren<by_distance>(view_, tree_.nodes[0], here_);
    std::int32_t at = 0;
    while (true) {
      const EdgeNode& node = tree_.nodes[static_cast<std::size_t>(at)];
      Lanes<float, EdgeNode::kWidth> sums{};
      for (std::size_t k = 0; k < EdgeNode::kWidth; ++k) {
        if (here_.importance[k] > 0.0F) {
          sums[k] = node.child[k] >= 0 ? LookBelow(node.child[k], k) : WeighLeaf(node.child[k], k);
        }
      }
      const int chosen = Choose(sums, u, probability);
      if (chosen < 0) {
        return {};
      }
      const auto lane = static_cast<std::size_t>(chosen);
      at = node.child[lane];
      if (at < 0) {
        const EdgeLeaf& leaf = tree_.leaves[static_cast<std::size_t>(~at)];
        const int edge = Choose(std::span(edges_[lane]).first(LeafSize(leaf)), u, probability);
        return edge < 0 ? EdgeTree::Pick{} : EdgeTree::Pick{leaf.first_edge + edge, probability, u};
      }
      here_ = below_[lane];
    }
  }

 private:
  static std::size_t LeafSize(const EdgeLeaf& leaf) {
    return static_cast<std::size_t>(leaf.num_blocks) * EdgeBlock::kWidth;
  }

  float LookBelow(std::int32_t child, std::size_t lane) {
    WeighChildren<by_distance>(view_, tree_.nodes[static_cast<std::size_t>(child)], below_[lane]);
    const auto& v = below_[lane].importance;
    return (v[0] + v[1]) + (v[2] + v[3]);
  }

  float WeighLeaf(std::int32_t child, std::size_t lane) {
    const EdgeLeaf& leaf = tree_.leaves[static_cast<std::size_t>(~child)];
    const auto& d = here_.towards;
    LeafImportance& values = edges_[lane];
    for (std::size_t i = 0; i < static_cast<std::size_t>(leaf.num_blocks); ++i) {
      WeighBlock<by_distance>(view_,
                              tree_.blocks[static_cast<std::size_t>(leaf.first_block) + i],
                              {d[0][lane], d[1][lane], d[2][lane]},
                              leaf.slack,
                              &values[i * EdgeBlock::kWidth]);
    }
    float sum = 0.0F;
    for (std::size_t i = 0; i < LeafSize(leaf); ++i) {
      sum += values[i];
    }
    return sum;
  }

  const EdgeHierarchy& tree_;
  const View view_;
  Children here_;
  Lanes<Children, EdgeNode::kWidth> below_;
  Lanes<LeafImportance, EdgeNode::kWidth> edges_;
};

}  // namespace

EdgeTree::EdgeTree(std::vector<BoundaryEdge> edges) : tree_(BuildEdgeHierarchy(std::move(edges))) {
  std::vector<double> weights;
  weights.reserve(tree_.edges.size());
  for (std::size_t e = 0; e < tree_.edges.size(); ++e) {
    weights.push_back(tree_.edges[e].weight * tree_.edges[e].Length() * tree_.wedges[e]);
  }
  by_wedge_ = Distribution1D(weights);
}

EdgeTree::Pick EdgeTree::SampleFromPoint(const Vec3& y, bool by_distance, double u) const {
  const View view{y, 1.0F};
  if (tree_.nodes.empty()) {
    return {};
  }
  return by_distance ? Descent<true>(tree_, view).Run(u) : Descent<false>(tree_, view).Run(u);
}

EdgeTree::Pick EdgeTree::SampleAlongDirection(const Vec3& w, double u) const {
  return tree_.nodes.empty() ? Pick{} : Descent<false>(tree_, View{w, 0.0F}).Run(u);
}

EdgeTree::Pick EdgeTree::SampleByWedge(double u) const {
  Pick pick;
  if (by_wedge_.Empty()) {
    return pick;
  }
  pick.edge = by_wedge_.Sample(u, pick.remainder);
  pick.probability = by_wedge_.Probability(pick.edge);
  return pick;
}

}  // namespace pathfit::renderer
