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

/// Paths from the camera, traced side by side.
template <class Listener>
struct CameraBatch {
  explicit CameraBatch(const PathContext& context) : batch(context) {}
  std::array<std::optional<LatticeSampler>, kImageBatch> samplers;
  std::array<Ray, kImageBatch> rays;
  std::array<std::optional<Hit>, kImageBatch> hits;
  PathBatch<kImageBatch, LatticeSampler, Listener> batch;
};

}  // namespace

struct PixelEstimator::Scratch : CameraBatch<NullListener> {
  using CameraBatch::CameraBatch;
};

PixelEstimator::PixelEstimator(const PathContext& context,
                               const CameraModel& camera,
                               const RenderOptions& options)
    : context_(context),
      camera_(camera),
      options_(options),
      scratch_(std::make_unique<Scratch>(context)) {}
PixelEstimator::~PixelEstimator() = default;

Rgba PixelEstimator::Estimate(int x, int y, RenderStats& stats) {
  const RayCaster& caster = context_.world->caster();
  const int pair = context_.antithetic ? 2 : 1;
  NullListener listener;
  auto& [samplers, rays, hits, batch] = *scratch_;
  const auto samples = [&](int first, const auto& numbers, std::span<Rgba> values) {
    const std::size_t count = values.size();
    for (std::size_t i = 0; i < count; ++i) {
      samplers[i].emplace(numbers(first + static_cast<int>(i)));
      rays[i] = FollowFilter(camera_, x, y, *samplers[i]).ray;
    }
    caster.Intersect({rays.data(), count}, true, {hits.data(), count});
    for (std::size_t i = 0; i < count; ++i) {
      if (hits[i]) {
        const bool mirrored = (first + static_cast<int>(i)) % pair == 1;
        batch.Start(
            i, *hits[i], rays[i], *samplers[i], listener, {context_.max_bounces, true, mirrored});
      }
    }
    batch.Trace();
    for (std::size_t i = 0; i < count; ++i) {
      values[i] = hits[i] ? Rgba(batch.radiance(i), 1.0) : ValueOfMiss(context_, rays[i]);
    }
  };
  return MeanOfSamples<kImageBatch>(context_, camera_, options_, x, y, pair, stats, samples);
}

struct PixelDerivative::Recorded {
  Recorded(const ShiftedSampler& sampler, const PathRecorder& recorder)
      : numbers(sampler), path(recorder) {}
  ShiftedSampler numbers;  // from the first vertex on
  PathRecorder path;
  bool mirrored = false;  // the second path of an antithetic pair
  PixelSample pixel;      // where the path starts, with its share of the weight
  bool missed = false;
  bool on_surface = false;  // the path has vertices, and its radiance is finite
  // Of a path that is drawn again.
  const SurfacePoint* start = nullptr;
  int first = 0;                         // vertex from which on it is new
  double share = 1.0;                    // see NearMotion
  NearMotion::VertexBits stand_ins = 0;  // before that vertex
  int alike = 0;                         // bounces that it has in common with others: see PathRange
  double light_share = 1.0;
  VertexAdjoint* shared = nullptr;  // of the first vertex
};

struct PixelDerivative::Level {
  explicit Level(const PathContext& context, const PathRecorder& recorder) : batch(context) {
    static const LatticeSampler::Shift kNone{CounterRng(0)};
    const ShiftedSampler none(LatticeSampler(kNone, CounterRng(0), 0));
    samples.assign(kImageBatch, Recorded(none, recorder));
    samplers.assign(kImageBatch, none);
  }
  std::vector<Recorded> samples;
  std::array<VertexAdjoint, kImageBatch> shared;  // of first vertices: of those drawn again
  struct Again {
    const Recorded* sample = nullptr;
    NearMotion::Split split;
  };
  std::vector<Again> again;  // what of them is to be drawn again
  std::vector<ShiftedSampler> samplers;
  PathBatch<kImageBatch, ShiftedSampler, PathRecorder> batch;
};

struct PixelDerivative::Scratch : CameraBatch<PathRecorder> {
  using CameraBatch::CameraBatch;
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
      scratch_(std::make_unique<Scratch>(context.path)),
      adjoint_(context, sum_) {}
PixelDerivative::~PixelDerivative() = default;

PixelDerivative::Level& PixelDerivative::LevelAt(std::size_t depth) {
  while (levels_.size() <= depth) {
    levels_.push_back(std::make_unique<Level>(context_.path, recorder_));
  }
  return *levels_[depth];
}

Rgba PixelDerivative::Estimate(int x, int y, RenderStats& stats) {
  sum_.Clear();
  const auto samples = [&](int first, const auto& numbers_of, std::span<Rgba> values) {
    std::vector<Recorded>& recorded = LevelAt(0).samples;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const int s = first + static_cast<int>(i);
      Recorded& sample = recorded[i];
      sample.mirrored = s % pair_ == 1;
      sample.numbers = ShiftedSampler(numbers_of(s));
      sample.pixel = spread_
                         ? CoverSupport(context_.camera, x, y, s / pair_ % points_, sample.numbers)
                         : FollowFilter(context_.camera, x, y, sample.numbers);
    }
    RecordTogether(values);
    AddRecorded(0, values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] *= recorded[i].pixel.weight;
    }
  };
  return MeanOfSamples<kImageBatch>(
      context_.path, context_.camera, options_, x, y, pair_ * points_, stats, samples);
}

/// Records the paths of the first samples, and their values.
void PixelDerivative::RecordTogether(std::span<Rgba> values) {
  const PathContext& path = context_.path;
  std::vector<Recorded>& samples = LevelAt(0).samples;
  const std::size_t count = values.size();
  auto& [samplers, rays, hits, batch] = *scratch_;
  for (std::size_t i = 0; i < count; ++i) {
    samplers[i] = samples[i].numbers;
    samples[i].path.Clear();
    rays[i] = samples[i].pixel.ray;
  }
  path.world->caster().Intersect({rays.data(), count}, true, {hits.data(), count});
  for (std::size_t i = 0; i < count; ++i) {
    if (hits[i]) {
      Recorded& sample = samples[i];
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
    samples[i].on_surface = hits[i] && IsFinite(values[i].Color());
    samples[i].missed = !hits[i];
  }
}

/// Records the first paths of a level and adds them.
void PixelDerivative::RecordAgain(std::size_t depth, std::size_t count) {
  Level& level = LevelAt(depth);
  for (std::size_t i = 0; i < count; ++i) {
    Recorded& sample = level.samples[i];
    sample.path.Clear();
    level.samplers[i] = sample.numbers;
    level.batch.Start(
        i,
        *sample.start,
        level.samplers[i],
        sample.path,
        {context_.path.max_bounces, true, sample.mirrored, sample.alike, sample.light_share});
  }
  level.batch.Trace();
  for (std::size_t i = 0; i < count; ++i) {
    level.samples[i].on_surface = IsFinite(level.batch.radiance(i));
  }
  AddRecorded(depth, count);
}

/// Adds the first paths of a level, or draws the rest of them again from each vertex that is close
/// to something that moves against it.
void PixelDerivative::AddRecorded(std::size_t depth, std::size_t count) {
  Level& level = LevelAt(depth);
  level.again.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const Recorded& sample = level.samples[i];
    if (!sample.on_surface) {
      if (sample.missed && context_.path.lights.ShowsEnvironment()) {
        adjoint_.AddMiss(sample.pixel);
      }
      continue;
    }
    const PathRecord& record = sample.path.record();
    const NearMotion::Split split = context_.near_motion->FirstSplit(
        record, context_.path, sample.first, sample.numbers.CanShift() ? sample.share : 0.0);
    if (split.count > 1) {
      level.again.push_back({&sample, split});
      continue;
    }
    adjoint_.AddPath(
        sample.pixel,
        record,
        split.touches ? static_cast<std::size_t>(split.vertex) : PathAdjoint::kNoContact,
        sample.stand_ins | split.stand_ins,
        sample.shared);
  }
  if (level.again.empty()) {
    return;
  }
  std::vector<Recorded>& next = LevelAt(depth + 1).samples;
  std::size_t filled = 0;
  for (std::size_t s = 0; s < level.again.size() && depth == 0; ++s) {
    level.shared[s] = {};
  }
  for (std::size_t s = 0; s < level.again.size(); ++s) {
    const auto& [sample, split] = level.again[s];
    const double each = 1.0 / split.count;
    for (int i = 0; i < split.count; ++i) {
      Recorded& again = next[filled++];
      again.numbers = sample->numbers;
      // Half of them evenly over all directions: where the surface grazes, the derivative does not
      // vanish with the cosine.
      again.numbers.ShiftDirection(
          split.vertex + 1,
          i / 2 * 2 * each,
          i / 2 * kGoldenStep,
          i % 2 == 0 ? DirectionDraw::kMixedBsdf : DirectionDraw::kMixedUniform);
      again.mirrored = sample->mirrored;
      again.pixel = Scaled(sample->pixel, each);
      again.start = &sample->path.record().vertices.front().p;
      again.first = split.vertex + 1;
      again.share = sample->share * each;
      again.stand_ins = sample->stand_ins | split.stand_ins;
      // The first split only: those of the next begin with different directions.
      again.alike = depth == 0 ? split.vertex + 1 : sample->alike;
      again.light_share =
          depth > 0 ? sample->light_share : (i == 0 ? static_cast<double>(split.count) : 0.0);
      again.shared = depth == 0 ? &level.shared[s] : sample->shared;
      if (filled == kImageBatch) {
        RecordAgain(depth + 1, filled);
        filled = 0;
      }
    }
  }
  if (filled > 0) {
    RecordAgain(depth + 1, filled);
  }
  for (std::size_t s = 0; s < level.again.size() && depth == 0; ++s) {
    const Recorded& sample = *level.again[s].sample;
    if (adjoint_.SharesFirst(sample.path.record())) {
      adjoint_.AddFirst(sample.pixel, sample.path.record(), level.shared[s]);
    }
  }
}

}  // namespace pathfit::renderer
