#include "renderer/derivative/own_corners.h"

#include <algorithm>
#include <cmath>

namespace pathfit::renderer {
namespace {

// Triangles of this share of the reach are small.
constexpr double kSmall = 0.25;

double LongestEdge(const TriangleGeometry& t) {
  return std::sqrt(std::max({SquaredNorm(t.e1), SquaredNorm(t.e2), SquaredNorm(t.e2 - t.e1)}));
}

}  // namespace

OwnCorners::OwnCorners(const RayCaster& caster, int mesh, std::size_t num_meshes, double reach)
    : caster_(caster), mesh_(mesh), only_(num_meshes, 0.0), reach_(reach) {
  only_[static_cast<std::size_t>(mesh)] = reach;
  const std::size_t count = 2 * caster.NumTriangles(mesh);
  radius_ = std::make_unique<std::atomic<float>[]>(count);
  for (std::size_t i = 0; i < count; ++i) {
    radius_[i].store(-1.0F, std::memory_order_relaxed);
  }
}

double OwnCorners::NearnessAt(const SurfacePoint& p, double side) const {
  const TriangleGeometry& t = caster_.Geometry(p.id);
  const Vec3 n = p.ng * side;
  const double size = LongestEdge(t);
  float radius = static_cast<float>(reach_);
  if (size < kSmall * reach_) {
    std::atomic<float>& known =
        radius_[2 * static_cast<std::size_t>(p.id.triangle) + (p.side * side > 0.0 ? 0 : 1)];
    radius = known.load(std::memory_order_relaxed);
    if (radius < 0.0F) {
      std::call_once(tree_made_, [&] {
        const auto triangles = caster_.TrianglesOf(mesh_);
        tree_.emplace(std::vector(triangles.begin(), triangles.end()));
      });
      const Vec3 middle = t.Point(1.0 / 3.0, 1.0 / 3.0);
      double slack = 0.0;
      for (const Vec3& corner : t.Corners()) {
        slack = std::max(slack, Norm(corner - middle));
      }
      radius = static_cast<float>(
          caster_.SearchRadius(middle, n, {only_, reach_}, slack, mesh_, *tree_));
      known.store(radius, std::memory_order_relaxed);
    }
  }
  return radius > 0.0F ? caster_.Nearness(p.x, n, {only_, reach_}, 1.0, radius) : 1.0;
}

}  // namespace pathfit::renderer
