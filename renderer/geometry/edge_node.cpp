#include "renderer/geometry/edge_node.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "renderer/core/parallel.h"
#include "renderer/geometry/tangent_wedge.h"
#include "renderer/math/box.h"
#include "renderer/math/frame.h"

namespace pathfit::renderer {
namespace {

constexpr std::size_t kMaxLeafEdges = EdgeLeaf::kMaxBlocks * EdgeBlock::kWidth;
// Rounding of single precision in the tests of nodes and edges, relative to their terms.
constexpr double kRounding = 2e-6;
// What one radian of normals is worth when a range is split, in units of the tree's size.
constexpr float kNormalScale = 0.08F;

/// What a range is split by: middle of the edge and direction of its normals.
struct Key {
  std::array<float, 6> at{};
  std::int32_t edge = 0;
};

using Range = std::span<Key>;

struct Moments {
  Box box;               // of the ends
  Vec3 sum;              // of normals
  Vec3 diagonal, mixed;  // of the sum of n n^T: (xx, yy, zz), (xy, xz, yz)
};

class Builder {
 public:
  explicit Builder(std::vector<BoundaryEdge> edges) : edges_(std::move(edges)) {}

  EdgeHierarchy Build() {
    MakeKeys();
    EdgeHierarchy out;
    if (!keys_.empty()) {
      out.nodes.emplace_back();
      std::vector<Subtree> subtrees;
      BuildNode(0, keys_, kTopLevels, out, &subtrees);
      ParallelFor(static_cast<std::int64_t>(subtrees.size()), [&](std::int64_t i) {
        Subtree& s = subtrees[static_cast<std::size_t>(i)];
        s.built.nodes.emplace_back();
        BuildNode(0, s.range, 0, s.built, nullptr);
      });
      for (const Subtree& s : subtrees) {
        Append(s, out);
      }
    }
    out.edges.reserve(edges_.size());
    out.wedges.reserve(edges_.size());
    const auto add = [&](std::int32_t e) {
      out.edges.push_back(edges_[static_cast<std::size_t>(e)]);
      out.wedges.push_back(wedges_[static_cast<std::size_t>(e)]);
    };
    for (const Key& key : keys_) add(key.edge);
    for (const std::int32_t e : parallel_) add(e);
    return out;
  }

 private:
  /// A part of the tree that is built on its own.
  struct Subtree {
    std::size_t node = 0, lane = 0;  // where it hangs
    Range range;
    EdgeHierarchy built;
  };
  /// Splits above this depth are made one after the other, all below in parallel.
  static constexpr int kTopLevels = 2;

  const BoundaryEdge& Edge(const Key& key) const {
    return edges_[static_cast<std::size_t>(key.edge)];
  }

  void MakeKeys();
  std::size_t SplitPoint(Range range) const;
  /// Below `levels`, if there are any, parts that are no leaves are left to `subtrees`.
  void BuildNode(std::size_t node,
                 Range range,
                 int levels,
                 EdgeHierarchy& out,
                 std::vector<Subtree>* subtrees) const;
  static void Append(const Subtree& subtree, EdgeHierarchy& out);
  void SetLane(EdgeNode& node, std::size_t lane, Range range) const;
  Moments MomentsOf(Range range) const;
  std::int32_t BuildLeaf(Range range, const Vec3& center, EdgeHierarchy& out) const;

  std::vector<BoundaryEdge> edges_;
  std::vector<Key> keys_;
  std::vector<double> wedges_;  // WedgeAngle of each edge
  std::vector<std::int32_t> parallel_;
  double weight_scale_ = 1.0;  // makes the weights of single precision at most 1
};

void Builder::MakeKeys() {
  Box box;
  double total = 0.0;
  for (const BoundaryEdge& e : edges_) {
    box.Include(e.a);
    box.Include(e.b);
    total += e.weight * e.Length();
  }
  const double size = Norm(box.Size());
  const double scale = size > 0.0 ? 1.0 / size : 0.0;
  weight_scale_ = total > 0.0 ? 1.0 / total : 0.0;
  keys_.reserve(edges_.size());
  wedges_.resize(edges_.size());
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const BoundaryEdge& e = edges_[i];
    wedges_[i] = WedgeAngle(e);
    if (!(wedges_[i] > 0.0) || !(e.weight * e.Length() > 0.0)) {
      parallel_.push_back(static_cast<std::int32_t>(i));
      continue;
    }
    Key key;
    key.edge = static_cast<std::int32_t>(i);
    const Vec3 middle = ((e.a - box.low) + (e.b - box.low)) * (0.5 * scale);
    const Vec3 normal = (e.n0 + e.n1) * 0.5;
    for (int k = 0; k < 3; ++k) {
      key.at[static_cast<std::size_t>(k)] = static_cast<float>(middle[k]);
      key.at[static_cast<std::size_t>(k) + 3] = kNormalScale * static_cast<float>(normal[k]);
    }
    keys_.push_back(key);
  }
  // Borders are seen from everywhere: a subtree with one could never be skipped.
  std::stable_partition(
      keys_.begin(), keys_.end(), [&](const Key& key) { return Edge(key).border; });
}

/// Splits in two: borders from the rest, else at the median along the longest extent.
std::size_t Builder::SplitPoint(Range range) const {
  if (Edge(range.front()).border && !Edge(range.back()).border) {
    const auto first =
        std::find_if(range.begin(), range.end(), [&](const Key& key) { return !Edge(key).border; });
    return static_cast<std::size_t>(first - range.begin());
  }
  std::array<float, 6> low = range.front().at;
  std::array<float, 6> high = low;
  for (const Key& key : range) {
    for (std::size_t i = 0; i < 6; ++i) {
      low[i] = std::min(low[i], key.at[i]);
      high[i] = std::max(high[i], key.at[i]);
    }
  }
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 6; ++i) {
    axis = high[i] - low[i] > high[axis] - low[axis] ? i : axis;
  }
  const std::size_t half = range.size() / 2;
  const auto before = [axis](const Key& a, const Key& b) {
    return a.at[axis] != b.at[axis] ? a.at[axis] < b.at[axis] : a.edge < b.edge;
  };
  std::nth_element(
      range.begin(), range.begin() + static_cast<std::ptrdiff_t>(half), range.end(), before);
  return half;
}

void Builder::BuildNode(std::size_t node,
                        Range range,
                        int levels,
                        EdgeHierarchy& out,
                        std::vector<Subtree>* subtrees) const {
  std::array<Range, EdgeNode::kWidth> parts;
  parts[0] = range;
  if (range.size() > kMaxLeafEdges) {
    const auto cut = [&](std::size_t i, std::size_t j) {
      if (parts[i].size() > 1) {
        const std::size_t at = SplitPoint(parts[i]);
        parts[j] = parts[i].subspan(at);
        parts[i] = parts[i].first(at);
      }
    };
    cut(0, 2);
    cut(0, 1);
    cut(2, 3);
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].empty()) {
      continue;
    }
    SetLane(out.nodes[node], i, parts[i]);
    if (parts[i].size() <= kMaxLeafEdges) {
      const EdgeNode& n = out.nodes[node];
      out.nodes[node].child[i] = ~BuildLeaf(parts[i], {n.x[i], n.y[i], n.z[i]}, out);
    } else if (subtrees != nullptr && levels == 1) {
      subtrees->push_back({node, i, parts[i], {}});
    } else {
      const std::size_t child = out.nodes.size();
      out.nodes[node].child[i] = static_cast<std::int32_t>(child);
      out.nodes.emplace_back();
      BuildNode(child, parts[i], levels - 1, out, subtrees);
    }
  }
}

void Builder::Append(const Subtree& subtree, EdgeHierarchy& out) {
  const auto nodes = static_cast<std::int32_t>(out.nodes.size());
  const auto leaves = static_cast<std::int32_t>(out.leaves.size());
  const auto blocks = static_cast<std::int32_t>(out.blocks.size());
  out.nodes[subtree.node].child[subtree.lane] = nodes;
  for (EdgeNode node : subtree.built.nodes) {
    for (std::size_t k = 0; k < EdgeNode::kWidth; ++k) {
      if (node.weight[k] > 0.0F) {
        node.child[k] += node.child[k] >= 0 ? nodes : -leaves;
      }
    }
    out.nodes.push_back(node);
  }
  for (EdgeLeaf leaf : subtree.built.leaves) {
    leaf.first_block += blocks;
    out.leaves.push_back(leaf);
  }
  out.blocks.insert(out.blocks.end(), subtree.built.blocks.begin(), subtree.built.blocks.end());
}

Moments Builder::MomentsOf(Range range) const {
  Moments m;
  for (const Key& key : range) {
    const BoundaryEdge& e = Edge(key);
    m.box.Include(e.a);
    m.box.Include(e.b);
    for (const Vec3& n : {e.n0, e.n1}) {
      m.sum += n;
      m.diagonal += {n.x * n.x, n.y * n.y, n.z * n.z};
      m.mixed += {n.x * n.y, n.x * n.z, n.y * n.z};
    }
  }
  return m;
}

/// Frame with n along the mean normal and s along the greatest spread across it.
Frame PrincipalFrame(const Moments& m) {
  const double norm = Norm(m.sum);
  const Frame frame = Frame::FromNormal(norm > 1e-9 ? m.sum * (1.0 / norm) : Vec3{0.0, 0.0, 1.0});
  const auto moment = [&](const Vec3& a, const Vec3& b) {
    const Vec3 row{Dot({m.diagonal.x, m.mixed.x, m.mixed.y}, b),
                   Dot({m.mixed.x, m.diagonal.y, m.mixed.z}, b),
                   Dot({m.mixed.y, m.mixed.z, m.diagonal.z}, b)};
    return Dot(a, row);
  };
  const double angle = 0.5 * std::atan2(2.0 * moment(frame.s, frame.t),
                                        moment(frame.s, frame.s) - moment(frame.t, frame.t));
  const Vec3 s = frame.s * std::cos(angle) + frame.t * std::sin(angle);
  return {s, Cross(frame.n, s), frame.n};
}

void Builder::SetLane(EdgeNode& node, std::size_t lane, Range range) const {
  const Moments moments = MomentsOf(range);
  const Vec3 center = moments.box.Middle();
  const Frame frame = PrincipalFrame(moments);
  Box normals;
  double squared_radius = 0.0;
  double thickness = 0.0;
  double weight = 0.0;
  double arcs = 0.0;
  for (const Key& key : range) {
    const BoundaryEdge& e = Edge(key);
    const Vec3 a = e.a - center;
    const Vec3 b = e.b - center;
    squared_radius = std::max({squared_radius, SquaredNorm(a), SquaredNorm(b)});
    for (const Vec3& n : {e.n0, e.n1}) {
      thickness = std::max({thickness, std::abs(Dot(n, a)), std::abs(Dot(n, b))});
      normals.Include(frame.ToLocal(n));
    }
    const double length = e.weight * Norm(b - a) * weight_scale_;
    weight += length;
    arcs += length * wedges_[static_cast<std::size_t>(key.edge)];
  }
  const Vec3 middle = normals.Middle();
  const Vec3 half = normals.Size() * 0.5 + Vec3{1.0, 1.0, 1.0} * kRounding;
  double squared_round = 0.0;
  for (const Key& key : range) {
    for (const Vec3& n : {Edge(key).n0, Edge(key).n1}) {
      const double p = (Dot(frame.s, n) - middle.x) / half.x;
      const double q = (Dot(frame.t, n) - middle.y) / half.y;
      squared_round = std::max(squared_round, p * p + q * q);
    }
  }
  node.x[lane] = center.x;
  node.y[lane] = center.y;
  node.z[lane] = center.z;
  const Vec3 normal = frame.ToWorld(middle);
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    node.normal[k][lane] = static_cast<float>(normal[i]);
    node.axis1[k][lane] = static_cast<float>(frame.s[i] * half.x);
    node.axis2[k][lane] = static_cast<float>(frame.t[i] * half.y);
  }
  node.squared_round[lane] = static_cast<float>(squared_round * (1.0 + kRounding));
  node.depth[lane] = static_cast<float>(half.z + kRounding);
  node.thickness[lane] = static_cast<float>(thickness + kRounding * std::sqrt(squared_radius));
  node.squared_radius[lane] = static_cast<float>(squared_radius);
  node.weight[lane] = static_cast<float>(weight);
  node.arcs[lane] = static_cast<float>(arcs);
}

std::int32_t Builder::BuildLeaf(Range range, const Vec3& center, EdgeHierarchy& out) const {
  EdgeLeaf leaf;
  leaf.first_block = static_cast<std::int32_t>(out.blocks.size());
  leaf.num_blocks =
      static_cast<std::int32_t>((range.size() + EdgeBlock::kWidth - 1) / EdgeBlock::kWidth);
  leaf.first_edge = static_cast<std::int32_t>(range.data() - keys_.data());
  out.blocks.resize(out.blocks.size() + static_cast<std::size_t>(leaf.num_blocks));
  double slack = 0.0;
  for (std::size_t i = 0; i < range.size(); ++i) {
    const BoundaryEdge& e = Edge(range[i]);
    EdgeBlock& block =
        out.blocks[static_cast<std::size_t>(leaf.first_block) + i / EdgeBlock::kWidth];
    const std::size_t lane = i % EdgeBlock::kWidth;
    const Vec3 middle = ((e.a - center) + (e.b - center)) * 0.5;
    const Vec3 half = (e.b - e.a) * 0.5;
    for (int k = 0; k < 3; ++k) {
      const auto axis = static_cast<std::size_t>(k);
      block.n0[axis][lane] = static_cast<float>(e.n0[k]);
      block.n1[axis][lane] = static_cast<float>(e.n1[k]);
      block.middle[axis][lane] = static_cast<float>(middle[k]);
    }
    block.o0[lane] = static_cast<float>(Dot(e.n0, middle));
    block.o1[lane] = static_cast<float>(Dot(e.n1, middle));
    block.squared_half[lane] = static_cast<float>(SquaredNorm(half));
    block.weight[lane] = static_cast<float>(e.weight * e.Length() * weight_scale_);
    slack = std::max({slack,
                      std::abs(Dot(e.n0, half)) + kRounding * Norm(middle),
                      std::abs(Dot(e.n1, half)) + kRounding * Norm(half)});
  }
  leaf.slack = static_cast<float>(slack);
  out.leaves.push_back(leaf);
  return static_cast<std::int32_t>(out.leaves.size()) - 1;
}

}  // namespace

EdgeHierarchy BuildEdgeHierarchy(std::vector<BoundaryEdge> edges) {
  return Builder(std::move(edges)).Build();
}

}  // namespace pathfit::renderer
