#include "renderer/derivative/pixel_estimator.h"

namespace pathfit::renderer {
namespace {

constexpr std::uint64_t kShiftDomain = 1;
constexpr std::uint64_t kInteriorDomain = 2;

/// One camera path. `on_miss(direction)` and `on_path()` are called after the path, if its radiance
/// is finite.
template <class Recorder, class OnMiss, class OnPath>
Rgba SamplePixel(const PathContext& context,
                 const CameraModel& camera,
                 int x,
                 int y,
                 LatticeSampler& sampler,
                 Recorder& recorder,
                 OnMiss on_miss,
                 OnPath on_path) {
  const double u = x + sampler.Next();
  const double v = y + sampler.Next();
  const Ray ray = camera.RayThrough(u, v);
  const std::optional<Hit> hit = context.caster->Intersect(ray);
  if (!hit) {
    if (!context.lights.environment || !context.lights.environment_visible) {
      return {};
    }
    on_miss(ray.direction);
    return {EnvironmentRadianceInWorld(*context.lights.environment, ray.direction), 0.0};
  }
  const SurfacePoint p = MakeSurfacePoint(*context.scene, *context.caster, *hit, ray);
  const Rgb radiance = TraceRadiance(context, p, sampler, recorder);
  if (IsFinite(radiance)) {
    on_path();
  }
  return {radiance, 1.0};
}

template <class Sample>
Rgba MeanOfSamples(const PathContext& context,
                   const CameraModel& camera,
                   const RenderOptions& options,
                   int x,
                   int y,
                   RenderStats& stats,
                   Sample sample) {
  const bool background_is_black =
      !context.lights.environment || !context.lights.environment_visible;
  if (background_is_black && !context.bounds.Contains(x, y)) {
    return {};
  }
  const auto pixel =
      static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(camera.camera().width) +
      static_cast<std::uint64_t>(x);
  const CounterRng shift(options.seed, kShiftDomain, options.view, pixel, 0);
  Rgba sum;
  for (int s = 0; s < options.spp; ++s) {
    const auto index = static_cast<std::uint64_t>(s);
    LatticeSampler sampler(
        shift, CounterRng(options.seed, kInteriorDomain, options.view, pixel, index), index);
    const Rgba value = sample(sampler);
    if (IsFinite(value.Color())) {
      sum += value;
    } else {
      ++stats.non_finite_samples;
    }
  }
  stats.paths += options.spp;
  return sum * (1.0 / options.spp);
}

}  // namespace

Rgba EstimatePixel(const PathContext& context,
                   const CameraModel& camera,
                   const RenderOptions& options,
                   int x,
                   int y,
                   RenderStats& stats) {
  NullPathRecorder recorder;
  return MeanOfSamples(context, camera, options, x, y, stats, [&](LatticeSampler& sampler) {
    return SamplePixel(
        context, camera, x, y, sampler, recorder, [](const Vec3&) {}, [] {});
  });
}

Rgba EstimatePixelWithDerivative(const PathContext& context,
                                 const CameraModel& camera,
                                 const RenderOptions& options,
                                 const ActiveParameters& active,
                                 int x,
                                 int y,
                                 PathRecorder& recorder,
                                 DerivativeAccumulator& sum,
                                 RenderStats& stats) {
  return MeanOfSamples(context, camera, options, x, y, stats, [&](LatticeSampler& sampler) {
    recorder.Clear();
    return SamplePixel(
        context,
        camera,
        x,
        y,
        sampler,
        recorder,
        [&](const Vec3& direction) {
          AccumulateEnvironmentAdjoint(
              *context.lights.environment, direction, Rgb::Constant(1.0), active, sum);
        },
        [&] { AccumulatePathAdjoint(context, active, recorder, sum); });
  });
}

}  // namespace pathfit::renderer
