#include "optim/problem/photo_density.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "renderer/core/parallel.h"
#include "renderer/geometry/ray_caster.h"
#include "renderer/sensor/camera.h"

namespace pathfit::optim {
namespace {

constexpr double kLeastCosine = 0.05;  // seen flatter, a point is not seen
constexpr std::size_t kChunk = 1024;   // points of one task

/// Which points a view shows, and how large: pixels per square metre.
class PointSights {
 public:
  PointSights(const renderer::Scene& scene, std::span<const SurfacePoint> points)
      : scene_(scene), points_(points), meshes_(renderer::WorldMeshes(scene)) {
    std::vector<const renderer::Mesh*> pointers;
    for (const renderer::Mesh& mesh : meshes_) pointers.push_back(&mesh);
    caster_.Build(pointers);
  }

  /// Of the points with open(i) calls wanted(i, density) where one lies in the view's valid pixels,
  /// and seen(i, density) if that is true and nothing is before it; from several threads, once a
  /// point.
  template <class Open, class Wanted, class Seen>
  void LookThrough(int view,
                   const PackedLevel& level,
                   const Open& open,
                   const Wanted& wanted,
                   const Seen& seen) const {
    // The pose may be fitted: it is the scene's, the size that of the photo.
    const renderer::Camera camera =
        renderer::ScaledCamera(scene_.sensors[static_cast<std::size_t>(view)],
                               level.camera().width,
                               level.camera().height);
    const renderer::CameraModel model(camera);
    const renderer::Image weights = level.ColorWeight();
    const auto look = [&](std::size_t i) {
      if (!open(i)) return;
      const SurfacePoint& point = points_[i];
      const auto pixel_of = model.Project(point.x);
      if (!pixel_of || pixel_of->u < 0.0 || pixel_of->v < 0.0 || pixel_of->u >= camera.width ||
          pixel_of->v >= camera.height) {
        return;
      }
      const auto pixel =
          static_cast<std::size_t>(pixel_of->v) * static_cast<std::size_t>(camera.width) +
          static_cast<std::size_t>(pixel_of->u);
      if (!(weights.data[pixel] > 0.0F)) return;
      const double density = model.DensityAt(point.x, point.n).value;
      if (!wanted(i, density)) return;
      double distance = 0.0;
      renderer::Ray ray = model.RayTo(point.x, distance);
      const double cosine = Dot(ray.direction, point.n);
      if (distance <= 0.0 || std::abs(cosine) < kLeastCosine) return;
      ray.origin += point.n * std::copysign(caster_.Offset(point.x), cosine);
      if (!caster_.Occluded(ray, distance)) seen(i, density);
    };
    const std::size_t chunks = (points_.size() + kChunk - 1) / kChunk;
    renderer::ParallelFor(static_cast<std::int64_t>(chunks), [&](std::int64_t chunk) {
      const std::size_t first = static_cast<std::size_t>(chunk) * kChunk;
      const std::size_t end = std::min(points_.size(), first + kChunk);
      for (std::size_t i = first; i < end; ++i) look(i);
    });
  }

 private:
  const renderer::Scene& scene_;
  std::span<const SurfacePoint> points_;
  std::vector<renderer::Mesh> meshes_;
  renderer::RayCaster caster_;
};

}  // namespace

std::vector<double> PhotoDensities(const renderer::Scene& scene,
                                   const FitViews& views,
                                   std::span<const SurfacePoint> points,
                                   double stop_at) {
  const PointSights sights(scene, points);
  std::vector<double> densities(points.size(), 0.0);
  for (const int v : views.fitted) {
    sights.LookThrough(
        v,
        views.levels[static_cast<std::size_t>(v)],
        [&](std::size_t i) { return densities[i] < stop_at; },
        [&](std::size_t i, double density) { return density > densities[i]; },
        [&](std::size_t i, double density) { densities[i] = density; });
  }
  return densities;
}

std::vector<int> PhotoCounts(const renderer::Scene& scene,
                             const ObservationSet& observations,
                             double scale,
                             std::span<const SurfacePoint> points) {
  const PointSights sights(scene, points);
  std::vector<int> counts(points.size(), 0);
  for (const int v : ListViews(observations).fitted) {
    const View& view = observations.views[static_cast<std::size_t>(v)];
    sights.LookThrough(
        v,
        PackedLevel(view, observations, scale),
        [](std::size_t) { return true; },
        [](std::size_t, double) { return true; },
        [&](std::size_t i, double) { ++counts[i]; });
  }
  return counts;
}

}  // namespace pathfit::optim
