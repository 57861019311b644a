#include "renderer/derivative/pixel_estimator.h"

#include "renderer/sensor/pixel_filter.h"

namespace pathfit::renderer {
namespace {

constexpr int kMirrorGroup = 4;
// Shifts by multiples of (1 / n, 1 / golden ratio) fill the unit square evenly.
constexpr double kGoldenStep = 0.6180339887498949;

/// What the path of one pixel sample found.
struct PathValue {
  enum class Kind { kDark, kSky, kSurface } kind = Kind::kDark;
  Rgba value;
};

/// One camera path.
template <PathListener Listener>
PathValue SamplePixel(const PathContext& context,
                      const PixelSample& pixel,
                      bool mirrored,
                      LatticeSampler& sampler,
                      Listener& listener) {
  const std::optional<Hit> hit = context.world->caster().Intersect(pixel.ray);
  if (!hit) {
    if (!context.lights.environment || !context.lights.environment_visible) {
      return {};
    }
    return {PathValue::Kind::kSky,
            {EnvironmentRadianceInWorld(*context.lights.environment, pixel.ray.direction), 0.0}};
  }
  const SurfacePoint p = MakeSurfacePoint(*context.world, *hit, pixel.ray);
  return {
      PathValue::Kind::kSurface,
      {TraceRadiance(context, p, sampler, listener, {context.max_bounces, true, mirrored}), 1.0}};
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
  NullListener listener;
  const int pair = context.antithetic ? 2 : 1;
  return MeanOfSamples(
      context, camera, options, x, y, pair, stats, [&](LatticeSampler& sampler, int s) {
        const PixelSample pixel = FollowFilter(camera, x, y, sampler);
        return SamplePixel(context, pixel, s % pair == 1, sampler, listener).value;
      });
}

struct PixelDerivative::Place {
  int x, y;
  int mirror;     // of the filter's support, 0 to 3
  bool mirrored;  // the second path of an antithetic pair
};

PixelDerivative::PixelDerivative(const AdjointContext& context,
                                 const RenderOptions& options,
                                 const std::vector<bool>* touches)
    : context_(context),
      options_(options),
      spread_(context.form == DerivativeForm::kMaterial &&
              context.camera.camera().filter.shape != PixelFilter::Shape::kBox),
      pair_(context.path.antithetic ? 2 : 1),
      points_(spread_ ? kMirrorGroup : 1),
      recorder_(touches == nullptr ? PathRecorder() : PathRecorder(*touches)),
      adjoint_(context, sum_) {}

Rgba PixelDerivative::Estimate(int x, int y, RenderStats& stats) {
  sum_.Clear();
  return MeanOfSamples(context_.path,
                       context_.camera,
                       options_,
                       x,
                       y,
                       pair_ * points_,
                       stats,
                       [&](const LatticeSampler& numbers, int s) {
                         const Place place{x, y, s / pair_ % points_, s % pair_ == 1};
                         const Rgba value = Record(place, numbers);
                         const PixelSample pixel = pixel_;
                         AddRecorded(place, numbers, pixel, 0, 1.0);
                         return value * pixel.weight;
                       });
}

/// Records the path of these numbers.
Rgba PixelDerivative::Record(const Place& place, LatticeSampler numbers) {
  pixel_ = spread_ ? CoverSupport(context_.camera, place.x, place.y, place.mirror, numbers)
                   : FollowFilter(context_.camera, place.x, place.y, numbers);
  recorder_.Clear();
  const PathValue found = SamplePixel(context_.path, pixel_, place.mirrored, numbers, recorder_);
  on_surface_ = found.kind == PathValue::Kind::kSurface && IsFinite(found.value.Color());
  if (found.kind == PathValue::Kind::kSky) {
    adjoint_.AddMiss(pixel_);
  }
  return found.value;
}

/// Adds the recorded path, or draws the rest of it again from each vertex (from `first` on) that is
/// close to something that moves against it. `part`: where the path starts, with its share of the
/// weight; `share`: see NearMotion.
void PixelDerivative::AddRecorded(const Place& place,
                                  const LatticeSampler& numbers,
                                  const PixelSample& part,
                                  int first,
                                  double share) {
  if (!on_surface_) {
    return;
  }
  const NearMotion::Split split = context_.near_motion->FirstSplit(
      recorder_.record(), context_.path, first, numbers.CanShift() ? share : 0.0);
  if (split.count == 1) {
    adjoint_.AddPath(
        part,
        recorder_.record(),
        split.touches ? static_cast<std::size_t>(split.vertex) : PathAdjoint::kNoContact);
    return;
  }
  const double each = 1.0 / split.count;
  for (int i = 0; i < split.count; ++i) {
    LatticeSampler shifted = numbers;
    // Half of them evenly over all directions: where the surface grazes, the derivative does not
    // vanish with the cosine.
    shifted.ShiftDirection(split.vertex + 1,
                           i / 2 * 2 * each,
                           i / 2 * kGoldenStep,
                           i % 2 == 0 ? DirectionDraw::kMixedBsdf : DirectionDraw::kMixedUniform);
    Record(place, shifted);
    AddRecorded(place, shifted, Scaled(part, each), split.vertex + 1, share * each);
  }
}

}  // namespace pathfit::renderer
