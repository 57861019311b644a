#include "renderer/io/polygon_fan.h"

#include <algorithm>
#include <cmath>

namespace pathfit::renderer {
namespace {

/// Bounds the time for polygons with very many corners.
constexpr std::size_t kMaxApexTries = 256;

using Ring = std::vector<std::size_t>;

/// Corners that differ from the one before them, around the polygon.
Ring DistinctCorners(std::span<const Vec3> corners) {
  Ring ring;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (ring.empty() || !(corners[i] == corners[ring.back()])) ring.push_back(i);
  }
  while (ring.size() > 1 && corners[ring.front()] == corners[ring.back()]) ring.pop_back();
  return ring;
}

/// Twice the smallest area of the fan's triangles, signed along the unit `normal`.
double SmallestSignedArea(std::span<const Vec3> corners,
                          const Ring& ring,
                          std::size_t apex,
                          const Vec3& normal) {
  const std::size_t count = ring.size();
  const Vec3& a = corners[ring[apex]];
  double smallest = HUGE_VAL;
  for (std::size_t k = 1; k + 1 < count; ++k) {
    const Vec3& b = corners[ring[(apex + k) % count]];
    const Vec3& c = corners[ring[(apex + k + 1) % count]];
    smallest = std::min(smallest, Dot(normal, Cross(b - a, c - a)));
  }
  return smallest;
}

std::optional<std::size_t> FindApex(std::span<const Vec3> corners, const Ring& ring) {
  if (ring.size() < 4) return 0;
  Vec3 normal;
  const Vec3& origin = corners[ring[0]];
  for (std::size_t k = 1; k + 1 < ring.size(); ++k) {
    normal += Cross(corners[ring[k]] - origin, corners[ring[k + 1]] - origin);
  }
  const double length = Norm(normal);
  if (!(length > 0.0) || !std::isfinite(length)) return 0;
  normal = normal / length;
  const std::size_t tries = std::min(ring.size(), kMaxApexTries);
  // Collinear corners leave triangles of no area; rounding must not turn those into folds.
  const double slack = -1e-12 * length;
  std::optional<std::size_t> flat_apex;
  for (std::size_t apex = 0; apex < tries; ++apex) {
    const double smallest = SmallestSignedArea(corners, ring, apex, normal);
    if (smallest > -slack) return apex;
    if (smallest >= slack && !flat_apex) flat_apex = apex;
  }
  return flat_apex;
}

}  // namespace

std::optional<FanTriangles> TriangulatePolygon(std::span<const Vec3> corners) {
  Ring ring = DistinctCorners(corners);
  if (corners.size() <= 3 || ring.size() < 3) {
    ring.clear();
    for (std::size_t i = 0; i < corners.size(); ++i) ring.push_back(i);
  }
  const std::optional<std::size_t> apex = FindApex(corners, ring);
  if (!apex) return std::nullopt;
  FanTriangles triangles;
  const std::size_t count = ring.size();
  for (std::size_t k = 1; k + 1 < count; ++k) {
    triangles.push_back({ring[*apex], ring[(*apex + k) % count], ring[(*apex + k + 1) % count]});
  }
  return triangles;
}

}  // namespace pathfit::renderer
