#include "renderer/boundary/boundary_pass.h"

#include <algorithm>
#include <functional>

#include "renderer/boundary/direct_boundary.h"
#include "renderer/boundary/guide_store.h"
#include "renderer/boundary/indirect_boundary.h"
#include "renderer/boundary/pixel_boundary.h"
#include "renderer/boundary/primary_boundary.h"
#include "renderer/boundary/primary_guide.h"
#include "renderer/core/error.h"

namespace pathfit::renderer {
namespace {

constexpr std::uint64_t kShiftDomain = 4;
constexpr std::uint64_t kPilotDomain = 5;
constexpr std::uint64_t kSampleDomain = 6;
constexpr std::int64_t kSamplesPerTask = 512;
constexpr std::int64_t kTasksPerWave = 128;  // bounds the memory of splats that wait for the sink
// Every way to draw samples keeps at least this share of the budget.
constexpr double kLeastShare = 0.05;
// Steps of the second and third number in units of the first one's: powers of the inverse of the
// plastic number, whose multiples spread evenly.
constexpr double kStep1 = 0.7548776662466927;
constexpr double kStep2 = 0.5698402909980532;

/// Calls sample(index, splats, stats) for all indices in parallel and flushes in order.
template <class Sample>
void ForEachSample(const BoundaryContext& context,
                   std::int64_t count,
                   DerivativeSink& sink,
                   RenderStats& stats,
                   Sample sample) {
  const std::int64_t tasks = (count + kSamplesPerTask - 1) / kSamplesPerTask;
  for (std::int64_t first = 0; first < tasks; first += kTasksPerWave) {
    const std::int64_t wave = std::min(kTasksPerWave, tasks - first);
    std::vector<SplatBuffer> buffers(static_cast<std::size_t>(wave));
    std::vector<RenderStats> by_task(static_cast<std::size_t>(wave));
    ParallelFor(wave, [&](std::int64_t i) {
      ThrowIfCancelled(context.services.cancel);
      const auto slot = static_cast<std::size_t>(i);
      const std::int64_t begin = (first + i) * kSamplesPerTask;
      const std::int64_t end = std::min(count, begin + kSamplesPerTask);
      for (std::int64_t s = begin; s < end; ++s) {
        const SplatBuffer::Mark mark = buffers[slot].Position();
        sample(s, buffers[slot], by_task[slot]);
        if (!std::isfinite(buffers[slot].MagnitudeSince(mark))) {
          buffers[slot].Rewind(mark);
          ++by_task[slot].non_finite_samples;
        }
      }
      by_task[slot].edge_samples += end - begin;
    });
    for (std::size_t i = 0; i < buffers.size(); ++i) {
      buffers[i].Flush(context.camera.camera().gain, sink);
      stats += by_task[i];
    }
  }
}

/// A map from three uniform numbers to samples, with its guide.
struct Way {
  int dimensions = 3;
  std::function<void(
      const std::array<double, 3>&, double weight, IndependentSampler&, SplatBuffer&)>
      sample;
  PrimaryGuide guide;
  std::int64_t budget = 0;
};

void LearnGuides(const BoundaryContext& context,
                 std::int64_t num_pilots,
                 std::uint64_t stream,
                 std::vector<Way>& ways) {
  const RenderOptions& options = context.options;
  for (std::size_t w = 0; w < ways.size(); ++w) {
    const Way& way = ways[w];
    ways[w].guide = PrimaryGuide::Build(
        options.guide,
        way.dimensions,
        num_pilots / static_cast<std::int64_t>(ways.size()),
        [&](const std::array<double, 3>& u, std::int64_t index) {
          IndependentSampler sampler(CounterRng(options.seed,
                                                kPilotDomain + 100 * stream + 1000 * w,
                                                options.view,
                                                static_cast<std::uint64_t>(index),
                                                0));
          SplatBuffer splats;
          way.sample(u, 1.0, sampler, splats);
          const std::vector<float>* weights = context.services.pixel_weights;
          return weights != nullptr ? splats.WeightedMagnitude(*weights)
                                    : splats.MagnitudeSince({});
        });
  }
}

void DivideBudget(std::int64_t budget, std::vector<Way>& ways) {
  double total = 0.0;
  for (const Way& way : ways) {
    total += way.guide.Mass();
  }
  const double least = kLeastShare / static_cast<double>(ways.size());
  for (Way& way : ways) {
    const double share =
        total > 0.0 ? way.guide.Mass() / total : 1.0 / static_cast<double>(ways.size());
    way.budget = static_cast<std::int64_t>(
        std::ceil(static_cast<double>(budget) * (least + (1.0 - kLeastShare) * share)));
  }
}

/// Takes kept guides or learns new ones; returns what it spent.
std::int64_t PrepareGuides(const BoundaryContext& context,
                           std::int64_t budget,
                           std::uint64_t stream,
                           std::vector<Way>& ways) {
  const RenderOptions& options = context.options;
  if (options.guide == GuideKind::kNone) {
    return 0;
  }
  GuideStore* store = context.services.guides;
  if (store != nullptr) {
    const std::vector<PrimaryGuide>* kept = store->Find(options.view, stream);
    if (kept != nullptr && kept->size() == ways.size()) {
      for (std::size_t w = 0; w < ways.size(); ++w) {
        ways[w].guide = (*kept)[w];
      }
      return 0;
    }
  }
  const auto pilots = static_cast<std::int64_t>(options.guide_share * static_cast<double>(budget));
  LearnGuides(context, pilots, stream, ways);
  if (store != nullptr) {
    std::vector<PrimaryGuide> learned;
    for (const Way& way : ways) {
      learned.push_back(way.guide);
    }
    store->Keep(options.view, stream, std::move(learned));
  }
  return pilots;
}

/// `stream` separates the random numbers of different estimators.
void RunWays(const BoundaryContext& context,
             std::int64_t budget,
             std::uint64_t stream,
             std::vector<Way> ways,
             DerivativeSink& sink,
             RenderStats& stats) {
  if (ways.empty() || budget <= 0) {
    return;
  }
  const RenderOptions& options = context.options;
  const std::int64_t pilots = PrepareGuides(context, budget, stream, ways);
  DivideBudget(budget - pilots, ways);
  for (std::size_t w = 0; w < ways.size(); ++w) {
    const Way& way = ways[w];
    CounterRng shift(options.seed, kShiftDomain + 100 * stream + 1000 * w, options.view, 0, 0);
    const double shift1 = shift.Next();
    const double shift2 = shift.Next();
    const double inverse = 1.0 / static_cast<double>(way.budget);
    ForEachSample(
        context, way.budget, sink, stats, [&](std::int64_t i, SplatBuffer& splats, RenderStats&) {
          CounterRng rng(options.seed,
                         kSampleDomain + 100 * stream + 1000 * w,
                         options.view,
                         static_cast<std::uint64_t>(i),
                         0);
          const auto index = static_cast<double>(i);
          const auto wrapped = [](double x) { return x - std::floor(x); };
          const PrimaryGuide::Draw draw = way.guide.Sample((index + rng.Next()) * inverse,
                                                           wrapped(shift1 + index * kStep1),
                                                           wrapped(shift2 + index * kStep2));
          IndependentSampler sampler(rng);
          way.sample(draw.u, inverse / draw.pdf, sampler, splats);
        });
  }
}

void EmitSecondary(const BoundaryContext& context, DerivativeSink& sink, RenderStats& stats) {
  const RenderOptions& options = context.options;
  const Camera& camera = context.camera.camera();
  const double pixels = static_cast<double>(camera.width) * camera.height;
  if (options.terms.direct && context.path.max_bounces > 0) {
    const DirectBoundary direct(context);
    std::vector<Way> ways;
    for (int i = 0; i < direct.NumWays(); ++i) {
      ways.push_back(
          {direct.Dimensions(i),
           [&direct, i](const std::array<double, 3>& u,
                        double weight,
                        IndependentSampler& sampler,
                        SplatBuffer& splats) { direct.Sample(i, u, weight, sampler, splats); },
           {},
           0});
    }
    RunWays(context,
            static_cast<std::int64_t>(options.spp_direct * pixels),
            1,
            std::move(ways),
            sink,
            stats);
  }
  const IndirectBoundary indirect(context);
  if (options.terms.indirect && indirect.Exists()) {
    RunWays(context,
            static_cast<std::int64_t>(options.spp_indirect * pixels),
            2,
            {{3,
              [&indirect](const std::array<double, 3>& u,
                          double weight,
                          IndependentSampler& sampler,
                          SplatBuffer& splats) { indirect.Sample(u, weight, sampler, splats); },
              {},
              0}},
            sink,
            stats);
  }
}

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
  const bool secondary = (options.terms.direct && path.max_bounces > 0) ||
                         (options.terms.indirect && path.max_bounces > 1);
  std::shared_ptr<const EdgeTree> edges = std::make_shared<const EdgeTree>();
  if (secondary) {
    std::vector<bool> moves;
    for (const auto& mesh : active.meshes) {
      moves.push_back(mesh.moves);
    }
    edges = path.world->EdgesFor(moves, camera.Origin());
  }
  const BoundaryContext context{path, camera, active, options, services, *edges};
  const auto run = [&](const auto& estimator, double budget) {
    const std::int64_t count = estimator.NumSamples(budget);
    ForEachSample(context,
                  count,
                  sink,
                  stats,
                  [&](std::int64_t i, SplatBuffer& splats, RenderStats& task_stats) {
                    estimator.Sample(i, count, task_stats, splats);
                  });
  };
  if (options.terms.primary) {
    run(PrimaryBoundary(context), options.sppe);
  }
  const bool box = camera.camera().filter.shape == PixelFilter::Shape::kBox;
  if (options.terms.pixel && options.form == DerivativeForm::kMaterial && box) {
    run(PixelBoundary(context), options.spp_pixel);
  }
  if (secondary && !edges->Empty()) {
    EmitSecondary(context, sink, stats);
  }
}

}  // namespace pathfit::renderer
