#include "renderer/boundary/boundary_pass.h"

#include <algorithm>
#include <cmath>

#include "renderer/boundary/direct_boundary.h"
#include "renderer/boundary/indirect_boundary.h"
#include "renderer/boundary/pixel_boundary.h"
#include "renderer/boundary/primary_boundary.h"
#include "renderer/boundary/primary_guide.h"
#include "renderer/core/error.h"

namespace pathfit::renderer {
namespace {

constexpr std::int64_t kRaysPerTask = 512;
constexpr std::int64_t kTasksPerWave = 128;  // bounds the memory of splats that wait for the sink
constexpr std::int64_t kStrips = 16;         // of image rows that feed the sink at once
// Every way to draw samples keeps at least this share of the budget.
constexpr double kLeastShare = 0.05;
// Steps of the second and third number in units of the first one's: powers of the inverse of the
// plastic number, whose multiples spread evenly.
constexpr double kStep1 = 0.7548776662466927;
constexpr double kStep2 = 0.5698402909980532;

/// A technique's term and random streams.
struct Streams {
  DerivativeTerm term;
  RandomDomain shift, pilot, sample;
};

/// Draws the samples of techniques, guided, and feeds the sink.
class Runner {
 public:
  Runner(const BoundaryContext& context, DerivativeSink& sink, RenderStats& stats)
      : context_(context), options_(context.options), sink_(sink), stats_(stats) {}

  /// If its term is wanted and can be there.
  template <class Technique>
  void Run(const Streams& streams) {
    if (options_.Has(streams.term)) Run(Technique(context_), streams);
  }

 private:
  void Run(const BoundaryTechnique& technique, const Streams& streams) {
    ways_ = technique.Ways();
    std::int64_t budget = ways_.empty() ? 0 : technique.NumSamples();
    if (budget <= 0) {
      return;
    }
    double rays = 0.0;
    for (const BoundaryWay& way : ways_) {
      rays += static_cast<double>(budget) * way.num_rays / static_cast<double>(ways_.size());
    }
    sink_.BeginTerm(streams.term, static_cast<std::int64_t>(rays));
    budget -= PrepareGuides(technique, streams, budget);
    const std::vector<std::int64_t> counts = DivideBudget(budget);
    for (std::size_t w = 0; w < ways_.size(); ++w) {
      RunWay(technique, streams, w, counts[w]);
    }
  }

  [[nodiscard]] CounterRng Stream(RandomDomain domain, std::size_t way, std::int64_t index) const {
    return CounterRng(
        options_.seed, OfWay(domain, way), options_.view, static_cast<std::uint64_t>(index));
  }

  /// Takes kept guides or learns new ones; returns how many samples that cost.
  std::int64_t PrepareGuides(const BoundaryTechnique& technique,
                             const Streams& streams,
                             std::int64_t budget) {
    guides_.assign(ways_.size(), {});
    const auto guided = std::count_if(
        ways_.begin(), ways_.end(), [](const BoundaryWay& way) { return way.guided; });
    if (options_.guide == GuideKind::kNone || guided == 0) {
      return 0;
    }
    std::vector<PrimaryGuide>* kept = nullptr;
    if (context_.services.guides != nullptr) {
      kept = &context_.services.guides->guides()
                  .of[{options_.view, static_cast<std::uint64_t>(streams.pilot)}];
      if (kept->size() == ways_.size()) {
        guides_ = *kept;
        return 0;
      }
    }
    const auto pilots =
        static_cast<std::int64_t>(options_.guide_share * static_cast<double>(budget));
    for (std::size_t w = 0; w < ways_.size(); ++w) {
      if (ways_[w].guided) {
        guides_[w] = Learn(technique, streams, w, pilots / guided);
      }
    }
    if (kept != nullptr) {
      *kept = guides_;
    }
    return pilots;
  }

  [[nodiscard]] PrimaryGuide Learn(const BoundaryTechnique& technique,
                                   const Streams& streams,
                                   std::size_t w,
                                   std::int64_t num_pilots) const {
    const LatticeSampler::Shift shift(Stream(streams.shift, w, 0));
    return PrimaryGuide::Build(
        options_.guide,
        ways_[w].dimensions,
        num_pilots,
        [&](const std::array<double, 3>& u, std::int64_t index) {
          SplatBuffer splats;
          const CounterRng rng = Stream(streams.pilot, w, index);
          technique.Sample(w, {u, 1.0, static_cast<std::uint64_t>(index), rng, &shift}, splats);
          return splats.MagnitudeSince({});
        });
  }

  [[nodiscard]] std::vector<std::int64_t> DivideBudget(std::int64_t budget) const {
    double total = 0.0;
    for (const PrimaryGuide& guide : guides_) {
      total += guide.Mass();
    }
    const auto num_ways = static_cast<double>(guides_.size());
    const double least = kLeastShare / num_ways;
    std::vector<std::int64_t> counts;
    for (const PrimaryGuide& guide : guides_) {
      const double share = total > 0.0 ? guide.Mass() / total : 1.0 / num_ways;
      counts.push_back(static_cast<std::int64_t>(
          std::ceil(static_cast<double>(budget) * (least + (1.0 - kLeastShare) * share))));
    }
    return counts;
  }

  /// Samples run in parallel; the sink is fed in their order.
  void RunWay(const BoundaryTechnique& technique,
              const Streams& streams,
              std::size_t w,
              std::int64_t count) {
    const LatticeSampler::Shift shift(Stream(streams.shift, w, 0));
    const std::int64_t rays = ways_[w].num_rays;
    const std::int64_t per_task = std::max<std::int64_t>(1, kRaysPerTask / rays);
    const std::int64_t tasks = (count + per_task - 1) / per_task;
    for (std::int64_t first = 0; first < tasks; first += kTasksPerWave) {
      const std::int64_t wave = std::min(kTasksPerWave, tasks - first);
      std::vector<SplatBuffer> buffers(static_cast<std::size_t>(wave));
      ParallelFor(wave, [&](std::int64_t i) {
        ThrowIfCancelled(context_.services.cancel);
        SplatBuffer& splats = buffers[static_cast<std::size_t>(i)];
        const std::int64_t begin = (first + i) * per_task;
        const std::int64_t end = std::min(count, begin + per_task);
        for (std::int64_t s = begin; s < end; ++s) {
          const SplatBuffer::Mark mark = splats.Position();
          technique.Sample(w, DrawOf(streams, shift, w, s, count), splats);
          if (!std::isfinite(splats.MagnitudeSince(mark))) {
            splats.Rewind(mark);
            ++splats.stats.non_finite_samples;
          }
        }
        splats.stats.edge_samples += (end - begin) * rays;
        splats.ApplyGains(context_.camera.camera());
      });
      FeedSink(buffers);
      for (const SplatBuffer& splats : buffers) {
        stats_ += splats.stats;
      }
    }
  }

  /// Strips of image rows at once, the buffers in order.
  void FeedSink(const std::vector<SplatBuffer>& buffers) {
    const std::int64_t width = context_.camera.camera().width;
    const std::int64_t height = context_.camera.camera().height;
    ParallelFor(kStrips, [&](std::int64_t i) {
      const std::int64_t first = i * height / kStrips * width;
      const std::int64_t end = (i + 1) * height / kStrips * width;
      for (const SplatBuffer& splats : buffers) {
        splats.Feed(first, end, sink_);
      }
    });
  }

  /// Sample s of `count`, spread evenly over the guide's cells.
  [[nodiscard]] BoundaryDraw DrawOf(const Streams& streams,
                                    const LatticeSampler::Shift& shift,
                                    std::size_t w,
                                    std::int64_t s,
                                    std::int64_t count) const {
    CounterRng rng = Stream(streams.sample, w, s);
    const auto index = static_cast<double>(s);
    const double inverse = 1.0 / static_cast<double>(count);
    const auto wrapped = [](double x) { return x - std::floor(x); };
    const double u0 = (index + rng.Next()) * inverse;
    const double u1 = wrapped(shift.Of(0) + index * kStep1);
    const double u2 = wrapped(shift.Of(1) + index * kStep2);
    const PrimaryGuide::Draw draw = guides_[w].Sample(u0, u1, u2);
    return {draw.u, inverse / draw.pdf, static_cast<std::uint64_t>(s), rng, &shift};
  }

  const BoundaryContext& context_;
  const RenderOptions& options_;
  DerivativeSink& sink_;
  RenderStats& stats_;
  std::vector<BoundaryWay> ways_;
  std::vector<PrimaryGuide> guides_;
};

}  // namespace

void EmitBoundaries(const PathContext& interior,
                    const CameraModel& camera,
                    const ActiveParameters& active,
                    const RenderOptions& options,
                    const RenderServices& services,
                    DerivativeSink& sink,
                    RenderStats& stats) {
  if (!active.any_geometry) {
    return;
  }
  PathContext path = interior;
  path.antithetic = false;  // boundary samples trace single paths
  std::shared_ptr<const EdgeTree> edges = std::make_shared<const EdgeTree>();
  if (options.Has(DerivativeTerm::kDirect) || options.Has(DerivativeTerm::kIndirect)) {
    edges = path.world->EdgesFor(active.MovingMeshes(), camera.Origin());
  }
  const BoundaryContext context{
      path, camera, active, options, services, *edges, path.world->contacts()};
  using enum RandomDomain;
  Runner runner(context, sink, stats);
  runner.Run<PrimaryBoundary>(
      {DerivativeTerm::kPrimary, kPrimaryShift, kPrimaryPilot, kPrimarySample});
  runner.Run<PixelBoundary>(
      {DerivativeTerm::kPixel, kPixelBorderShift, kPixelBorderPilot, kPixelBorderSample});
  runner.Run<DirectBoundary>({DerivativeTerm::kDirect, kDirectShift, kDirectPilot, kDirectSample});
  runner.Run<IndirectBoundary>(
      {DerivativeTerm::kIndirect, kIndirectShift, kIndirectPilot, kIndirectSample});
}

}  // namespace pathfit::renderer
