#include "renderer/geometry/surface_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/core/check.h"
#include "renderer/core/parallel.h"
#include "renderer/geometry/closest_point.h"
#include "renderer/geometry/embree_compat.h"
#include "renderer/geometry/mesh_checks.h"
#include "renderer/sampler/counter_rng.h"

namespace pathfit::renderer {
namespace {

/// Barycentrics of a point in the plane of a triangle.
MeshPoint PointAt(const TriangleGeometry& t, std::int32_t triangle, const Vec3& x) {
  const double a = Dot(t.e1, t.e1), b = Dot(t.e1, t.e2), c = Dot(t.e2, t.e2);
  const double determinant = a * c - b * b;
  const Vec3 d = x - t.p0;
  MeshPoint point{triangle, 0.0, 0.0, x};
  if (determinant > 0.0) {
    point.b1 = std::clamp((c * Dot(d, t.e1) - b * Dot(d, t.e2)) / determinant, 0.0, 1.0);
    point.b2 = std::clamp((a * Dot(d, t.e2) - b * Dot(d, t.e1)) / determinant, 0.0, 1.0 - point.b1);
  }
  return point;
}

}  // namespace

struct NearestSurface::Index {
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = rtcNewScene(device);
  std::vector<TriangleGeometry> triangles;

  struct Query {
    const Index* index;
    Vec3 x;
    double distance = std::numeric_limits<double>::infinity();
    std::size_t triangle = 0;
    Vec3 nearest = {};
  };

  // Boxes and radii are widened by more than the rounding to float.
  static void Bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto& index = *static_cast<const Index*>(arguments->geometryUserPtr);
    const TriangleGeometry& t = index.triangles[arguments->primID];
    const Vec3 p1 = t.p0 + t.e1, p2 = t.p0 + t.e2;
    const auto set = [](double a, double b, double c, float& lower, float& upper) {
      const double margin = 1e-6 * std::max({std::abs(a), std::abs(b), std::abs(c)});
      lower = static_cast<float>(std::min({a, b, c}) - margin);
      upper = static_cast<float>(std::max({a, b, c}) + margin);
    };
    RTCBounds& box = *arguments->bounds_o;
    set(t.p0.x, p1.x, p2.x, box.lower_x, box.upper_x);
    set(t.p0.y, p1.y, p2.y, box.lower_y, box.upper_y);
    set(t.p0.z, p1.z, p2.z, box.lower_z, box.upper_z);
  }
  static bool Closer(RTCPointQueryFunctionArguments* arguments) {
    auto& query = *static_cast<Query*>(arguments->userPtr);
    const Vec3 nearest = ClosestPointOfTriangle(query.x, query.index->triangles[arguments->primID]);
    const double distance = Norm(nearest - query.x);
    if (!(distance < query.distance)) return false;
    query.distance = distance;
    query.triangle = arguments->primID;
    query.nearest = nearest;
    arguments->query->radius = static_cast<float>(distance * (1.0 + 1e-6));
    return true;
  }
};

NearestSurface::NearestSurface(const Mesh& mesh) : index_(std::make_unique<Index>()) {
  PATHFIT_CHECK(!mesh.triangles.empty());
  index_->triangles = GeometryOf(mesh);
  RTCGeometry geometry = rtcNewGeometry(index_->device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(index_->triangles.size()));
  rtcSetGeometryUserData(geometry, index_.get());
  rtcSetGeometryBoundsFunction(geometry, Index::Bounds, index_.get());
  rtcSetGeometryPointQueryFunction(geometry, Index::Closer);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(index_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(index_->scene);
}

NearestSurface::~NearestSurface() {
  rtcReleaseScene(index_->scene);
  rtcReleaseDevice(index_->device);
}

MeshPoint NearestSurface::Nearest(const Vec3& x) const {
  Index::Query query{index_.get(), x};
  RTCPointQuery at{static_cast<float>(x.x),
                   static_cast<float>(x.y),
                   static_cast<float>(x.z),
                   0.0F,
                   std::numeric_limits<float>::infinity()};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(index_->scene, &at, &context, nullptr, &query);
  return PointAt(
      index_->triangles[query.triangle], static_cast<std::int32_t>(query.triangle), query.nearest);
}

std::vector<MeshPoint> UniformPoints(const Mesh& mesh, int count) {
  std::vector<double> areas;
  double area = 0.0;
  for (const TriangleGeometry& t : GeometryOf(mesh)) {
    area += 0.5 * Norm(Cross(t.e1, t.e2));
    areas.push_back(area);
  }
  CounterRng rng(1);
  std::vector<MeshPoint> points;
  for (int i = 0; i < count; ++i) {
    const double at = (i + rng.Next()) / count * area;
    const auto found = std::upper_bound(areas.begin(), areas.end() - 1, at);
    const auto triangle = static_cast<std::size_t>(found - areas.begin());
    const TriangleGeometry t = GeometryOf(mesh, mesh.triangles[triangle]);
    const double root = std::sqrt(rng.Next());
    const double b2 = rng.Next() * root;
    const double b1 = root - b2;
    points.push_back({static_cast<std::int32_t>(triangle), b1, b2, t.p0 + t.e1 * b1 + t.e2 * b2});
  }
  return points;
}

SurfaceGap GapBetween(const Mesh& from, const std::vector<MeshPoint>& points, const Mesh& to) {
  PATHFIT_CHECK(!points.empty());
  const NearestSurface surface(to);
  std::vector<MeshPoint> nearest(points.size());
  const auto count = static_cast<double>(points.size());
  ParallelFor(static_cast<std::int64_t>(points.size()), [&](std::int64_t i) {
    const auto k = static_cast<std::size_t>(i);
    nearest[k] = surface.Nearest(points[k].x);
  });
  SurfaceGap gap;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double distance = Norm(nearest[i].x - points[i].x);
    gap.mean += distance / count;
    gap.rms += distance * distance / count;
    gap.most = std::max(gap.most, distance);
    const double cosine =
        Dot(TriangleNormal(from, points[i].triangle), TriangleNormal(to, nearest[i].triangle));
    gap.mean_angle += std::acos(std::clamp(cosine, -1.0, 1.0)) / count;
  }
  gap.rms = std::sqrt(gap.rms);
  return gap;
}

}  // namespace pathfit::renderer
