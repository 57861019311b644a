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

}  // namespace

std::vector<double> PhotoDensities(const renderer::Scene& scene,
                                   const FitViews& views,
                                   std::span<const SurfacePoint> points,
                                   double stop_at) {
  const std::vector<renderer::Mesh> meshes = renderer::WorldMeshes(scene);
  std::vector<const renderer::Mesh*> pointers;
  for (const renderer::Mesh& mesh : meshes) pointers.push_back(&mesh);
  renderer::RayCaster caster;
  caster.Build(pointers);
  std::vector<double> densities(points.size(), 0.0);
  for (const int v : views.fitted) {
    const PackedLevel& level = views.levels[static_cast<std::size_t>(v)];
    // The pose may be fitted: it is the scene's, the size that of the photo.
    const renderer::Camera camera = renderer::ScaledCamera(
        scene.sensors[static_cast<std::size_t>(v)], level.camera().width, level.camera().height);
    const renderer::CameraModel model(camera);
    const renderer::Image weights = level.ColorWeight();
    const auto look = [&](std::size_t i) {
      const SurfacePoint& point = points[i];
      if (densities[i] >= stop_at) return;
      const auto seen = model.Project(point.x);
      if (!seen || seen->u < 0.0 || seen->v < 0.0 || seen->u >= camera.width ||
          seen->v >= camera.height) {
        return;
      }
      const auto pixel =
          static_cast<std::size_t>(seen->v) * static_cast<std::size_t>(camera.width) +
          static_cast<std::size_t>(seen->u);
      if (!(weights.data[pixel] > 0.0F)) return;
      const double density = model.DensityAt(point.x, point.n).value;
      if (density <= densities[i]) return;
      double distance = 0.0;
      renderer::Ray ray = model.RayTo(point.x, distance);
      const double cosine = Dot(ray.direction, point.n);
      if (distance <= 0.0 || std::abs(cosine) < kLeastCosine) return;
      ray.origin += point.n * std::copysign(caster.Offset(point.x), cosine);
      if (!caster.Occluded(ray, distance)) densities[i] = density;
    };
    const std::size_t chunks = (points.size() + kChunk - 1) / kChunk;
    renderer::ParallelFor(static_cast<std::int64_t>(chunks), [&](std::int64_t chunk) {
      const std::size_t first = static_cast<std::size_t>(chunk) * kChunk;
      const std::size_t end = std::min(points.size(), first + kChunk);
      for (std::size_t i = first; i < end; ++i) look(i);
    });
  }
  return densities;
}

}  // namespace pathfit::optim
