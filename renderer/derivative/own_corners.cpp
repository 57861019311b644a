#include "renderer/derivative/own_corners.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pathfit::renderer {
namespace {

// Triangles of this share of the reach are small.
constexpr double kSmall = 0.25;

double LongestEdge(const TriangleGeometry& t) {
  return std::sqrt(std::max({SquaredNorm(t.e1), SquaredNorm(t.e2), SquaredNorm(t.e2 - t.e1)}));
}

}  // namespace

OwnCorners::OwnCorners(const RayCaster& caster, int mesh, std::size_t num_meshes, double reach)
    : caster_(caster), only_(num_meshes, false), reach_(reach) {
  only_[static_cast<std::size_t>(mesh)] = true;
  const std::size_t count = 2 * caster.NumTriangles(mesh);
  of_centre_ = std::make_unique<std::atomic<float>[]>(count);
  for (std::size_t i = 0; i < count; ++i) {
    of_centre_[i].store(-1.0F, std::memory_order_relaxed);
  }
}

double OwnCorners::DistanceAt(const SurfacePoint& p, double side) const {
  const TriangleGeometry& t = caster_.Geometry(p.id);
  const double size = LongestEdge(t);
  double reach = reach_;
  if (size < kSmall * reach_) {
    std::atomic<float>& known =
        of_centre_[2 * static_cast<std::size_t>(p.id.triangle) + (p.side * side > 0.0 ? 0 : 1)];
    float distance = known.load(std::memory_order_relaxed);
    if (distance < 0.0F) {
      distance = static_cast<float>(
          caster_.DistanceBefore(t.Point(1.0 / 3.0, 1.0 / 3.0), p.ng * side, only_, reach_));
      known.store(distance, std::memory_order_relaxed);
    }
    reach = std::min(reach_, distance + size);
    if (reach == reach_) {
      return std::numeric_limits<double>::infinity();
    }
  }
  const double found = caster_.DistanceBefore(p.x, p.ng * side, only_, reach);
  return found < reach ? found : std::numeric_limits<double>::infinity();
}

}  // namespace pathfit::renderer
