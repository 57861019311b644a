#include "renderer/geometry/own_corners.h"

#include <array>
#include <utility>

#include "renderer/math/box.h"

namespace pathfit::renderer {
namespace {

constexpr std::int32_t kLeafSize = 4;
constexpr std::size_t kMostNodesAside = 64;  // halves of at most 2^31 triangles
// Bounds of so many triangles are those of their corners; above, those of the nodes below.
constexpr std::int32_t kExactBounds = 64;
// Of the sine between two almost parallel normals.
constexpr double kSineRounding = 1e-7;

std::size_t Index(std::int32_t i) { return static_cast<std::size_t>(i); }

double Sine(double cosine) { return std::sqrt(std::max(0.0, 1.0 - cosine * cosine)); }

}  // namespace

class OwnCorners::Builder {
 public:
  Builder(std::span<const TriangleGeometry> triangles, Tree& tree)
      : triangles_(triangles), tree_(tree) {
    keys_.reserve(triangles.size());
    for (const TriangleGeometry& t : triangles) {
      const Vec3 middle = t.Point(1.0 / 3.0, 1.0 / 3.0);
      keys_.push_back({middle, static_cast<std::int32_t>(keys_.size())});
    }
    tree.nodes.reserve(triangles.size());
    if (!keys_.empty()) {
      Build(0, static_cast<std::int32_t>(keys_.size()));
    }
    tree.order.reserve(keys_.size());
    for (const Key& key : keys_) {
      tree.order.push_back(key.triangle);
    }
  }

 private:
  struct Key {
    Vec3 at;
    std::int32_t triangle = 0;
  };

  std::int32_t Build(std::int32_t first, std::int32_t count) {
    const auto index = static_cast<std::int32_t>(tree_.nodes.size());
    tree_.nodes.emplace_back();
    tree_.nodes.back().first = first;
    tree_.nodes.back().count = count;
    if (count > kLeafSize) {
      Split(first, count);
      Build(first, count / 2);
      const std::int32_t right = Build(first + count / 2, count - count / 2);
      tree_.nodes[Index(index)].right = right;
    }
    Node& node = tree_.nodes[Index(index)];
    count > kExactBounds ? BoundNodes(index, node) : BoundTriangles(node);
    return index;
  }

  /// At the median along the longest extent. Ties are broken by number, so that the tree is the
  /// same everywhere.
  void Split(std::int32_t first, std::int32_t count) {
    const auto begin = keys_.begin() + first;
    Box box;
    for (auto key = begin; key != begin + count; ++key) {
      box.Include(key->at);
    }
    const int axis = box.LongestAxis();
    std::nth_element(begin, begin + count / 2, begin + count, [axis](const Key& a, const Key& b) {
      return a.at[axis] != b.at[axis] ? a.at[axis] < b.at[axis] : a.triangle < b.triangle;
    });
  }

  template <class Use>
  void ForEachCorner(const Node& node, const Use& use) const {
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      for (const Vec3& p : triangles_[Index(keys_[Index(i)].triangle)].Corners()) {
        use(p);
      }
    }
  }

  void BoundTriangles(Node& node) const {
    Box box;
    ForEachCorner(node, [&](const Vec3& p) { box.Include(p); });
    node.center = box.Middle();
    Vec3 sum;
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const TriangleGeometry& t = triangles_[Index(keys_[Index(i)].triangle)];
      sum += t.n * t.double_area;
    }
    node.normal = UnitOf(sum);
    double squared = 0.0;
    ForEachCorner(node, [&](const Vec3& p) {
      squared = std::max(squared, SquaredNorm(p - node.center));
      node.thickness = std::max(node.thickness, std::abs(Dot(node.normal, p - node.center)));
    });
    node.radius = std::sqrt(squared);
  }

  void BoundNodes(std::int32_t index, Node& node) const {
    const std::array<const Node*, 2> below = {&tree_.nodes[Index(index + 1)],
                                              &tree_.nodes[Index(node.right)]};
    const Vec3 along = below[1]->center - below[0]->center;
    const double apart = Norm(along);
    // The sphere around both: from one's far end to the other's.
    const double part =
        apart > 0.0
            ? std::clamp(0.5 * (apart + below[1]->radius - below[0]->radius) / apart, 0.0, 1.0)
            : 0.5;
    node.center = below[0]->center + along * part;
    node.normal = UnitOf(below[0]->normal * below[0]->radius + below[1]->normal * below[1]->radius);
    for (const Node* n : below) {
      const Vec3 to = n->center - node.center;
      const double cosine = Dot(node.normal, n->normal);
      node.radius = std::max(node.radius, Norm(to) + n->radius);
      node.thickness = std::max(node.thickness,
                                std::abs(Dot(node.normal, to)) + std::abs(cosine) * n->thickness +
                                    Sine(cosine) * n->radius);
    }
  }

  static Vec3 UnitOf(const Vec3& sum) {
    const double norm = Norm(sum);
    return norm > 0.0 ? sum / norm : Vec3{0.0, 0.0, 1.0};
  }

  std::span<const TriangleGeometry> triangles_;
  Tree& tree_;
  std::vector<Key> keys_;
};

double OwnCorners::Nearness(const CornerView& view,
                            double reach,
                            double most,
                            NearFacts* facts) const {
  std::call_once(tree_made_, [&] { Builder(triangles_, tree_); });
  if (tree_.nodes.empty()) {
    return most;
  }
  double limit = most * reach;
  struct Aside {
    double least = 0.0, height = 0.0;  // distance and height of what is in the node, at least/most
    std::int32_t node = 0;
  };
  const auto bounds_of = [&](std::int32_t index) {
    const Node& node = tree_.nodes[Index(index)];
    const Vec3 to = node.center - view.x;
    const double cosine = Dot(view.n, node.normal);
    const double away =
        std::max(Norm(to) - node.radius, std::abs(Dot(node.normal, to)) - node.thickness);
    const double height = Dot(view.n, to) + std::abs(cosine) * node.thickness +
                          std::min(1.0, Sine(cosine) + kSineRounding) * node.radius;
    return Aside{away - view.Rounding(), height + view.Rounding(), index};
  };
  const auto counts = [&](const Aside& aside) {
    return aside.height > 0.0 && !IsTooFarOrFlat(aside.least / kAlmost, aside.height, limit);
  };
  std::array<Aside, kMostNodesAside> stack;
  stack[0] = bounds_of(0);
  std::size_t size = 1;
  while (size > 0) {
    const Aside at = stack[--size];
    if (!counts(at)) {
      continue;
    }
    const Node& node = tree_.nodes[Index(at.node)];
    if (node.right > 0) {
      Aside near = bounds_of(at.node + 1);
      Aside far = bounds_of(node.right);
      if (far.least < near.least) std::swap(near, far);
      for (const Aside& aside : {far, near}) {
        if (counts(aside)) stack[size++] = aside;
      }
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const NearCorner corner = CornerSeen(view, triangles_[Index(tree_.order[Index(i)])], limit);
      if (corner.rise > 0.0) {
        most = NearnessOf(view, corner) / reach;
        limit = most * reach;
        if (facts != nullptr) *facts = {reach, corner.meets};
      }
    }
  }
  return most;
}

}  // namespace pathfit::renderer
