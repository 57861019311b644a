#include "renderer/derivative/pixel_estimator.h"

#include <utility>

#include "renderer/sensor/pixel_filter.h"

namespace pathfit::renderer {
namespace {

constexpr int kMirrorGroup = 4;
// Shifts by multiples of (1 / n, 1 / golden ratio) fill the unit square evenly.
constexpr double kGoldenStep = 0.6180339887498949;

/// One camera path. `on_miss(pixel)` and `on_path(pixel)` are called after the path, if its
/// radiance is finite.
template <class Recorder, class OnMiss, class OnPath>
Rgba SamplePixel(const PathContext& context,
                 const PixelSample& pixel,
                 bool mirrored,
                 LatticeSampler& sampler,
                 Recorder& recorder,
                 OnMiss on_miss,
                 OnPath on_path) {
  const std::optional<Hit> hit = context.world->caster().Intersect(pixel.ray);
  if (!hit) {
    if (!context.lights.environment || !context.lights.environment_visible) {
      return {};
    }
    on_miss();
    return {EnvironmentRadianceInWorld(*context.lights.environment, pixel.ray.direction), 0.0};
  }
  const SurfacePoint p = MakeSurfacePoint(*context.world, *hit, pixel.ray);
  const Rgb radiance =
      TraceRadiance(context, p, sampler, recorder, {context.max_bounces, true, mirrored});
  if (IsFinite(radiance)) {
    on_path();
  }
  return {radiance, 1.0};
}

/// Pixel sample that follows the filter.
PixelSample FollowFilter(const CameraModel& camera, int x, int y, LatticeSampler& sampler) {
  const PixelFilter& filter = camera.camera().filter;
  PixelSample pixel;
  pixel.u = x + 0.5 + SampleFilter(filter, sampler.Next());
  pixel.v = y + 0.5 + SampleFilter(filter, sampler.Next());
  pixel.ray = camera.RayThrough(pixel.u, pixel.v);
  return pixel;
}

/// Pixel sample spread evenly over the filter's support, with weight and slope; `mirror` 0..3
/// reflects it about the pixel's axes.
PixelSample CoverSupport(
    const CameraModel& camera, int x, int y, int mirror, LatticeSampler& sampler) {
  const PixelFilter& filter = camera.camera().filter;
  const auto offset = [&](bool reflect) {
    const double d = filter.radius * (2.0 * sampler.Next() - 1.0);
    return reflect ? -d : d;
  };
  const double du = offset((mirror & 1) != 0);
  const double dv = offset((mirror & 2) != 0);
  const double inverse_pdf = 4.0 * filter.radius * filter.radius;
  const double h_u = FilterProfile(filter, du);
  const double h_v = FilterProfile(filter, dv);
  PixelSample pixel;
  pixel.u = x + 0.5 + du;
  pixel.v = y + 0.5 + dv;
  pixel.ray = camera.RayThrough(pixel.u, pixel.v);
  pixel.weight = h_u * h_v * inverse_pdf;
  pixel.slope_u = FilterSlope(filter, du) * h_v * inverse_pdf;
  pixel.slope_v = h_u * FilterSlope(filter, dv) * inverse_pdf;
  return pixel;
}

PixelSample Scaled(PixelSample pixel, double share) {
  pixel.weight *= share;
  pixel.slope_u *= share;
  pixel.slope_v *= share;
  return pixel;
}

/// sample(sampler, index) returns the weighted value of one sample. `group` samples in a row share
/// their numbers.
template <class Sample>
Rgba MeanOfSamples(const PathContext& context,
                   const CameraModel& camera,
                   const RenderOptions& options,
                   int x,
                   int y,
                   int group,
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
  const CounterRng shift(options.seed, RandomDomain::kPixelShift, options.view, pixel);
  Rgba sum;
  // Only whole pairs have the right mean.
  const int spp = context.antithetic ? options.spp + options.spp % 2 : options.spp;
  for (int s = 0; s < spp; ++s) {
    const auto index = static_cast<std::uint64_t>(s / group);
    LatticeSampler sampler(
        shift,
        CounterRng(options.seed, RandomDomain::kPixelSample, options.view, pixel, index),
        index);
    if (context.antithetic && s % 2 == 1) {
      sampler.ShiftLights(kGoldenStep);
    }
    const Rgba value = sample(sampler, s);
    if (IsFinite(value.Color())) {
      sum += value;
    } else {
      ++stats.non_finite_samples;
    }
  }
  stats.paths += spp;
  return sum * (1.0 / spp);
}

}  // namespace

Rgba EstimatePixel(const PathContext& context,
                   const CameraModel& camera,
                   const RenderOptions& options,
                   int x,
                   int y,
                   RenderStats& stats) {
  NullPathRecorder recorder;
  const int pair = context.antithetic ? 2 : 1;
  return MeanOfSamples(
      context, camera, options, x, y, pair, stats, [&](LatticeSampler& sampler, int s) {
        const PixelSample pixel = FollowFilter(camera, x, y, sampler);
        return SamplePixel(
            context, pixel, s % pair == 1, sampler, recorder, [] {}, [] {});
      });
}

Rgba EstimatePixelWithDerivative(const AdjointContext& context,
                                 const RenderOptions& options,
                                 int x,
                                 int y,
                                 PathRecorder& recorder,
                                 DerivativeAccumulator& sum,
                                 RenderStats& stats) {
  const CameraModel& camera = context.camera;
  const bool spread = context.form == DerivativeForm::kMaterial &&
                      camera.camera().filter.shape != PixelFilter::Shape::kBox;
  const int pair = context.path.antithetic ? 2 : 1;
  const int points = spread ? kMirrorGroup : 1;
  return MeanOfSamples(
      context.path,
      camera,
      options,
      x,
      y,
      pair * points,
      stats,
      [&](const LatticeSampler& start, int s) {
        bool on_surface = false;
        // Records the path of these numbers.
        const auto trace = [&](LatticeSampler numbers) {
          const PixelSample pixel = spread ? CoverSupport(camera, x, y, s / pair % points, numbers)
                                           : FollowFilter(camera, x, y, numbers);
          recorder.Clear();
          on_surface = false;
          const Rgba value = SamplePixel(
              context.path,
              pixel,
              s % pair == 1,
              numbers,
              recorder,
              [&] { AccumulateMissAdjoint(context, pixel, sum); },
              [&] { on_surface = true; });
          return std::pair{value * pixel.weight, pixel};
        };
        const auto [value, pixel] = trace(start);
        // Adds the recorded path, or draws the rest of it again from each vertex (from `first` on)
        // that is close to something that moves against it.
        const auto add = [&](const auto& self,
                             const LatticeSampler& numbers,
                             const PixelSample& part,
                             int first,
                             double share) -> void {
          const NearMotion::Split split =
              on_surface ? context.near_motion->FirstSplit(
                               recorder, context.path, first, numbers.CanShift() ? share : 0.0)
                         : NearMotion::Split{};
          if (split.touches) {
            recorder.contact = static_cast<std::size_t>(split.vertex);
          }
          if (on_surface && split.count == 1) {
            AccumulatePathAdjoint(context, part, recorder, sum);
          }
          const double each = 1.0 / split.count;
          for (int i = 0; i < split.count && split.count > 1; ++i) {
            LatticeSampler shifted = numbers;
            // Half of them evenly over all directions: where the surface grazes, the derivative
            // does not vanish with the cosine.
            shifted.ShiftDirection(
                split.vertex + 1,
                i / 2 * 2 * each,
                i / 2 * kGoldenStep,
                i % 2 == 0 ? DirectionDraw::kMixedBsdf : DirectionDraw::kMixedUniform);
            trace(shifted);
            self(self, shifted, Scaled(part, each), split.vertex + 1, share * each);
          }
        };
        add(add, start, pixel, 0, 1.0);
        return value;
      });
}

}  // namespace pathfit::renderer
