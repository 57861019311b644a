#include "renderer/geometry/triangle_tree.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "renderer/geometry/closest_point.h"
#include "renderer/geometry/mesh_checks.h"

namespace pathfit::renderer {
namespace {

constexpr std::int32_t kLeafSize = 4;

double SquaredDistance(const Vec3& x, const Box& box) {
  double sum = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double d = std::max({box.low[i] - x[i], x[i] - box.high[i], 0.0});
    sum += d * d;
  }
  return sum;
}

std::array<double, 3> WeightsOf(const Vec3& x, const TriangleGeometry& t) {
  const Vec3 from = x - t.p0;
  const double inverse = 1.0 / t.double_area;
  const double b1 = std::clamp(Dot(t.n, Cross(from, t.e2)) * inverse, 0.0, 1.0);
  const double b2 = std::clamp(Dot(t.n, Cross(t.e1, from)) * inverse, 0.0, 1.0 - b1);
  return {1.0 - b1 - b2, b1, b2};
}

}  // namespace

TriangleTree::TriangleTree(const Mesh& mesh)
    : triangles_(GeometryOf(mesh)), order_(triangles_.size()) {
  std::vector<Vec3> middles;
  for (const TriangleGeometry& triangle : triangles_) {
    boxes_.push_back(BoxAround(triangle.Corners()));
    middles.push_back(boxes_.back().Middle());
  }
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(order_.size());
  Build(0, static_cast<std::int32_t>(order_.size()), middles);
}

std::int32_t TriangleTree::Build(std::int32_t first,
                                 std::int32_t count,
                                 const std::vector<Vec3>& middles) {
  const auto index = static_cast<std::int32_t>(nodes_.size());
  nodes_.push_back({{}, first, count, 0});
  Box spread;
  for (std::int32_t i = first; i < first + count; ++i) {
    const std::size_t t = Index(order_[Index(i)]);
    nodes_.back().box.Include(boxes_[t]);
    spread.Include(middles[t]);
  }
  if (count <= kLeafSize) return index;
  const int axis = spread.LongestAxis();
  const auto begin = order_.begin() + first;
  // Ties are broken by number, so that the tree is the same everywhere.
  std::nth_element(begin, begin + count / 2, begin + count, [&](std::int32_t a, std::int32_t b) {
    return std::pair(middles[Index(a)][axis], a) < std::pair(middles[Index(b)][axis], b);
  });
  Build(first, count / 2, middles);
  const std::int32_t right = Build(first + count / 2, count - count / 2, middles);
  nodes_[Index(index)].right = right;
  return index;
}

ClosestPoint TriangleTree::Closest(const Vec3& x) const { return Find(x, nullptr); }

ClosestPoint TriangleTree::Closest(const Vec3& x, const Vec3& outward) const {
  const ClosestPoint found = Find(x, &outward);
  return found.triangle >= 0 ? found : Find(x, nullptr);
}

ClosestPoint TriangleTree::Find(const Vec3& x, const Vec3* outward) const {
  ClosestPoint best;
  double least = std::numeric_limits<double>::infinity();
  std::array<std::pair<double, std::int32_t>, kMostNodesAside> stack;
  stack[0] = {0.0, 0};
  std::size_t size = 1;
  while (size > 0) {
    const auto [distance, index] = stack[--size];
    if (distance >= least) continue;
    const Node& node = nodes_[Index(index)];
    if (node.right > 0) {
      std::pair near{SquaredDistance(x, nodes_[Index(index + 1)].box), index + 1};
      std::pair far{SquaredDistance(x, nodes_[Index(node.right)].box), node.right};
      if (far < near) std::swap(near, far);
      stack[size++] = far;
      stack[size++] = near;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const std::int32_t t = order_[Index(i)];
      const TriangleGeometry& triangle = triangles_[Index(t)];
      if (outward != nullptr && Dot(triangle.n, *outward) <= 0.0) continue;
      const Vec3 y = ClosestPointOfTriangle(x, triangle);
      const double square = SquaredNorm(y - x);
      if (square < least || (square == least && t < best.triangle)) {
        least = square;
        best.triangle = t;
        best.position = y;
      }
    }
  }
  if (best.triangle >= 0) {
    best.weights = WeightsOf(best.position, triangles_[Index(best.triangle)]);
  }
  return best;
}

}  // namespace pathfit::renderer
