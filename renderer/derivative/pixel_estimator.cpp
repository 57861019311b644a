#include "renderer/derivative/pixel_estimator.h"

#include <array>
#include <optional>
#include <span>

#include "renderer/sensor/pixel_filter.h"

namespace pathfit::renderer {
namespace {

constexpr int kMirrorGroup = 4;
// Shifts by multiples of (1 / n, 1 / golden ratio) fill the unit square evenly.
constexpr double kGoldenStep = 0.6180339887498949;

// Paths of a pixel that are traced side by side: two packets, so that one stays full for longer
// while paths end.
constexpr std::size_t kImageBatch = 16;

/// What a camera ray that meets nothing finds.
Rgba ValueOfMiss(const PathContext& context, const Ray& ray) {
  return context.lights.ShowsEnvironment()
             ? Rgba(EnvironmentRadianceInWorld(*context.lights.environment, ray.direction), 0.0)
             : Rgba{};
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

/// Mean of the weighted values of a pixel's samples. samples(first, numbers, values) evaluates up
/// to N of them; `group` samples in a row share their numbers.
template <std::size_t N, class Samples>
Rgba MeanOfSamples(const PathContext& context,
                   const CameraModel& camera,
                   const RenderOptions& options,
                   int x,
                   int y,
                   int group,
                   RenderStats& stats,
                   Samples samples) {
  if (!context.lights.ShowsEnvironment() && !context.bounds.Contains(x, y)) {
    return {};
  }
  const auto pixel =
      static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(camera.camera().width) +
      static_cast<std::uint64_t>(x);
  const LatticeSampler::Shift shift(
      CounterRng(options.seed, RandomDomain::kPixelShift, options.view, pixel));
  const CounterRng::Family independent(options.seed, RandomDomain::kPixelSample, options.view);
  const auto numbers = [&](int s) {
    const auto index = static_cast<std::uint64_t>(s / group);
    LatticeSampler sampler(shift, CounterRng(independent, pixel, index), index);
    if (context.antithetic && s % 2 == 1) {
      sampler.ShiftLights(kGoldenStep);
    }
    return sampler;
  };
  Rgba sum;
  // Only whole pairs have the right mean.
  const int spp = context.antithetic ? options.spp + options.spp % 2 : options.spp;
  std::array<Rgba, N> values;
  constexpr int kStep = static_cast<int>(N);
  for (int first = 0; first < spp; first += kStep) {
    const auto count = static_cast<std::size_t>(std::min(kStep, spp - first));
    samples(first, numbers, std::span(values.data(), count));
    for (std::size_t i = 0; i < count; ++i) {
      if (IsFinite(values[i].Color())) {
        sum += values[i];
      } else {
        ++stats.non_finite_samples;
      }
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
  const RayCaster& caster = context.world->caster();
  const int pair = context.antithetic ? 2 : 1;
  // Scratch space of all batches.
  std::array<std::optional<LatticeSampler>, kImageBatch> samplers;
  std::array<Ray, kImageBatch> rays;
  std::array<std::optional<Hit>, kImageBatch> hits;
  PathBatch<kImageBatch, LatticeSampler, NullListener> batch(context);
  const auto samples = [&](int first, const auto& numbers, std::span<Rgba> values) {
    const std::size_t count = values.size();
    for (std::size_t i = 0; i < count; ++i) {
      samplers[i].emplace(numbers(first + static_cast<int>(i)));
      rays[i] = FollowFilter(camera, x, y, *samplers[i]).ray;
    }
    caster.Intersect({rays.data(), count}, true, {hits.data(), count});
    for (std::size_t i = 0; i < count; ++i) {
      if (hits[i]) {
        const bool mirrored = (first + static_cast<int>(i)) % pair == 1;
        batch.Start(
            i, *hits[i], rays[i], *samplers[i], listener, {context.max_bounces, true, mirrored});
      }
    }
    batch.Trace();
    for (std::size_t i = 0; i < count; ++i) {
      values[i] = hits[i] ? Rgba(batch.radiance(i), 1.0) : ValueOfMiss(context, rays[i]);
    }
  };
  return MeanOfSamples<kImageBatch>(context, camera, options, x, y, pair, stats, samples);
}

struct PixelDerivative::Recorded {
  ShiftedSampler numbers;  // from the first vertex on
  bool mirrored = false;   // the second path of an antithetic pair
  PixelSample pixel;       // where the path starts
  bool missed = false;
  bool on_surface = false;  // the path has vertices, and its radiance is finite
  PathRecorder path;
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
      adjoint_(context, sum_) {
  static const LatticeSampler::Shift kNone{CounterRng(0)};
  const PathRecorder recorder = touches == nullptr ? PathRecorder() : PathRecorder(*touches);
  for (std::size_t i = 0; i <= kImageBatch; ++i) {  // the last: paths that are drawn again
    samples_.push_back({ShiftedSampler(LatticeSampler(kNone, CounterRng(0), 0)),
                        false,
                        {},
                        false,
                        false,
                        recorder});
  }
}
PixelDerivative::~PixelDerivative() = default;

Rgba PixelDerivative::Estimate(int x, int y, RenderStats& stats) {
  sum_.Clear();
  const auto samples = [&](int first, const auto& numbers_of, std::span<Rgba> values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const int s = first + static_cast<int>(i);
      Recorded& sample = samples_[i];
      sample.mirrored = s % pair_ == 1;
      sample.numbers = ShiftedSampler(numbers_of(s));
      sample.pixel = spread_
                         ? CoverSupport(context_.camera, x, y, s / pair_ % points_, sample.numbers)
                         : FollowFilter(context_.camera, x, y, sample.numbers);
    }
    RecordTogether(values);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Recorded& sample = samples_[i];
      AddRecorded(sample, sample.pixel, 0, 1.0);
      values[i] *= sample.pixel.weight;
    }
  };
  return MeanOfSamples<kImageBatch>(
      context_.path, context_.camera, options_, x, y, pair_ * points_, stats, samples);
}

/// Records the paths of the first samples, and their values.
void PixelDerivative::RecordTogether(std::span<Rgba> values) {
  const PathContext& path = context_.path;
  const std::size_t count = values.size();
  std::array<std::optional<LatticeSampler>, kImageBatch> samplers;
  std::array<Ray, kImageBatch> rays;
  std::array<std::optional<Hit>, kImageBatch> hits;
  for (std::size_t i = 0; i < count; ++i) {
    samplers[i] = samples_[i].numbers;
    samples_[i].path.Clear();
    rays[i] = samples_[i].pixel.ray;
  }
  path.world->caster().Intersect({rays.data(), count}, true, {hits.data(), count});
  PathBatch<kImageBatch, LatticeSampler, PathRecorder> batch(path);
  for (std::size_t i = 0; i < count; ++i) {
    if (hits[i]) {
      Recorded& sample = samples_[i];
      batch.Start(i,
                  *hits[i],
                  rays[i],
                  *samplers[i],
                  sample.path,
                  {path.max_bounces, true, sample.mirrored});
    }
  }
  batch.Trace();
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = hits[i] ? Rgba(batch.radiance(i), 1.0) : ValueOfMiss(path, rays[i]);
    samples_[i].on_surface = hits[i] && IsFinite(values[i].Color());
    samples_[i].missed = !hits[i];
  }
}

/// Records the path from `first` on with other numbers, as the last of samples_.
void PixelDerivative::RecordAgain(const SurfacePoint& first,
                                  bool mirrored,
                                  ShiftedSampler numbers) {
  Recorded& again = samples_.back();
  again.numbers = numbers;
  again.mirrored = mirrored;
  again.path.Clear();
  const Rgb radiance = TraceRadiance(
      context_.path, first, numbers, again.path, {context_.path.max_bounces, true, mirrored});
  again.on_surface = IsFinite(radiance);
}

/// Adds the recorded path, or draws the rest of it again from each vertex (from `first` on) that is
/// close to something that moves against it. `part`: where the path starts, with its share of the
/// weight; `share`: see NearMotion.
void PixelDerivative::AddRecorded(const Recorded& sample,
                                  const PixelSample& part,
                                  int first,
                                  double share) {
  if (!sample.on_surface) {
    if (sample.missed && context_.path.lights.ShowsEnvironment()) {
      adjoint_.AddMiss(part);
    }
    return;
  }
  const PathRecord& record = sample.path.record();
  const NearMotion::Split split = context_.near_motion->FirstSplit(
      record, context_.path, first, sample.numbers.CanShift() ? share : 0.0);
  if (split.count == 1) {
    adjoint_.AddPath(
        part,
        record,
        split.touches ? static_cast<std::size_t>(split.vertex) : PathAdjoint::kNoContact);
    return;
  }
  const double each = 1.0 / split.count;
  // The sample may be the one that is recorded again.
  const ShiftedSampler numbers = sample.numbers;
  const SurfacePoint first_vertex = record.vertices.front().p;
  const bool mirrored = sample.mirrored;
  for (int i = 0; i < split.count; ++i) {
    ShiftedSampler shifted = numbers;
    // Half of them evenly over all directions: where the surface grazes, the derivative does not
    // vanish with the cosine.
    shifted.ShiftDirection(split.vertex + 1,
                           i / 2 * 2 * each,
                           i / 2 * kGoldenStep,
                           i % 2 == 0 ? DirectionDraw::kMixedBsdf : DirectionDraw::kMixedUniform);
    RecordAgain(first_vertex, mirrored, shifted);
    AddRecorded(samples_.back(), Scaled(part, each), split.vertex + 1, share * each);
  }
}

}  // namespace pathfit::renderer
