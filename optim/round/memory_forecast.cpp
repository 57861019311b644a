#include "optim/round/memory_forecast.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

#include "optim/checkpoint/fit_state.h"
#include "optim/prior/prior_terms.h"
#include "optim/problem/fit_views.h"
#include "optim/problem/image_problem.h"
#include "optim/problem/scene_image_source.h"
#include "optim/round/evaluation.h"
#include "optim/round/exposure_gauge.h"
#include "optim/round/round_policy.h"
#include "optim/round/stage_plan.h"
#include "optim/round/surface_levels.h"
#include "optim/solver/trust_region_solver.h"
#include "renderer/core/clock.h"
#include "renderer/core/process_memory.h"

namespace pathfit::optim {
namespace {

constexpr std::size_t kNumSampled = 8;  // views that are linearised
constexpr double kSceneCopies = 4.0;    // states, their averages, and what is rendered

constexpr std::array kRootFigures = {&RootSize::gathered_bytes,
                                     &RootSize::kept_bytes,
                                     &RootSize::num_panels,
                                     &RootSize::panel_blocks,
                                     &RootSize::jacobian_cells,
                                     &RootSize::product_cells};

/// Evenly over all that are fitted, and the first half of them as well.
std::vector<int> SampleViews(const std::vector<int>& fitted) {
  const std::size_t count = std::min(kNumSampled, fitted.size());
  std::vector<int> sampled;
  for (std::size_t first = 0; first < 2; ++first) {
    for (std::size_t i = first; i < count; i += 2) {
      sampled.push_back(fitted[i * fitted.size() / count]);
    }
  }
  return sampled;
}

/// What views add falls from view to view, as a power of their number: that from half of those
/// seen to all of them.
double Extrapolate(double of_half, double of_seen, double num_views_over_seen) {
  if (!(of_half > 0.0) || !(of_seen > of_half)) {
    return of_seen;
  }
  return of_seen * std::pow(num_views_over_seen, std::min(1.0, std::log2(of_seen / of_half)));
}

/// From the sizes after each sampled view; surfaces are seen once, what is seen of them in ever
/// more pairs.
ProblemSize SizeOfAll(const std::vector<ProblemSize>& sizes,
                      std::size_t num_views,
                      std::size_t num_blocks) {
  ProblemSize size = sizes.back();
  if (num_views <= sizes.size() || sizes.size() < 2) {
    return size;
  }
  const ProblemSize& half = sizes[sizes.size() / 2 - 1];
  const double more = static_cast<double>(num_views) / static_cast<double>(sizes.size());
  if (half.sparse_gram_seen > 0.0) {
    const double seen = std::min(static_cast<double>(num_blocks),
                                 Extrapolate(half.sparse_gram_seen, size.sparse_gram_seen, more));
    size.sparse_gram_bytes = seen * Extrapolate(half.sparse_gram_bytes / half.sparse_gram_seen,
                                                size.sparse_gram_bytes / size.sparse_gram_seen,
                                                more);
  }
  for (const auto figure : kRootFigures) {
    size.roots.*figure = Extrapolate(half.roots.*figure, size.roots.*figure, more);
  }
  return size;
}

// Of samples, near the ends of stages that move something: medians of six recorded fits.
constexpr renderer::SampleBudget kUsualSplit = [] {
  renderer::SampleBudget split = kStartSplit;
  split.sppe = 0.85;
  split.spp_direct = 0.02;
  return split;
}();
constexpr std::size_t kNumTimed = 2;  // views whose derivatives and images are timed
constexpr int kMoreSamples = 4;       // times, of the longer of two renderings, or a stage's last
constexpr int kMostSamples = 64;      // if they are no more than these
constexpr double kNumCandidates = 3;  // for the end of a stage
constexpr double kNudge = 1e-7;

/// Of photos of one size. A view's: a + b * samples per pixel.
struct ViewSeconds {
  double linearize = 0.0, linearize_sample = 0.0;
  double render_sample = 0.0;
  double step = 0.0;  ///< what is built anew where something has changed, by all views together
  [[nodiscard]] double Round(int spp, int trials) const {
    return linearize + spp * (linearize_sample + trials * render_sample);
  }
};
constexpr std::array kViewFigures = {&ViewSeconds::linearize,
                                     &ViewSeconds::linearize_sample,
                                     &ViewSeconds::render_sample,
                                     &ViewSeconds::step};

/// Of two sizes of a stage's photos, in shares of the last one's pixels: what a size takes beside
/// its pixels is told by the small one.
struct SizedSeconds {
  double small_pixels = 0.0;  ///< 0: there is the last size alone
  ViewSeconds small, last;
  [[nodiscard]] ViewSeconds At(double pixels) const {
    const double share = (pixels - small_pixels) / (1.0 - small_pixels);
    ViewSeconds seconds;
    for (const auto figure : kViewFigures) {
      seconds.*figure = std::max(0.0, small.*figure + share * (last.*figure - small.*figure));
    }
    return seconds;
  }
};

template <class Function>
double SecondsOf(Function function) {
  const auto start = renderer::Clock::now();
  function();
  return renderer::SecondsSince(start);
}

/// Of a scene that shares nothing else with others.
double BytesOfValues(const renderer::ParameterLayout& layout) {
  double bytes = 0.0;
  for (const renderer::ParameterGroup& group : layout.groups()) {
    bytes += static_cast<double>(group.num_blocks) * sizeof(renderer::Rgb);
  }
  return bytes;
}

/// What views take with few samples and with more.
struct MeasuredViews {
  int few = 1, more = 1;  ///< samples per pixel
  ProblemSize of_few, of_more;
  ViewSeconds seconds;  ///< from both
};

/// Where the smallest of steps leads that changes every scalar.
std::vector<double> Nudged(const std::vector<double>& values, const ParameterSet& set) {
  std::vector<double> theta = set.ThetaFromValues(values);
  for (std::size_t i = 0; i < theta.size(); ++i) {
    const double step = kNudge * std::max(1.0, std::abs(theta[i]));
    theta[i] += theta[i] + step < set.Upper(i) ? step : -step;
  }
  return set.ValuesFromTheta(theta);
}

/// `samples_of` makes those of a round. Without times: the sizes alone.
template <class Samples>
MeasuredViews MeasureViews(SceneImageSource& source,
                           FitViews views,
                           const ParameterSet& set,
                           ImageProblemOptions options,
                           const std::vector<double>& values,
                           int few,
                           int more,
                           Samples samples_of,
                           ForecastParts parts) {
  views.fitted.resize(std::min(kNumTimed, views.fitted.size()));
  const auto count = static_cast<double>(views.fitted.size());
  options.expected_views = views.fitted.size();
  options.num_measured = std::min(options.num_measured, views.fitted.size());
  const auto measure = [&](const std::vector<double>& at, int samples, ProblemSize& size) {
    options.samples = samples_of(samples);
    return SecondsOf([&] {
             ImageProblem problem(source, views, set, options);
             problem.Linearize(at);
             size = problem.size();
           }) /
           count;
  };
  MeasuredViews measured{few, more, {}, {}, {}};
  const double of_few = measure(values, few, measured.of_few);
  const double of_more = measure(values, more, measured.of_more);
  if (parts == ForecastParts::kMemory) return measured;
  ViewSeconds& times = measured.seconds;
  times.linearize_sample = std::max(0.0, (of_more - of_few) / (more - few));
  times.linearize = std::max(0.0, of_few - few * times.linearize_sample);
  const SampleHalves halves = samples_of(more);
  times.render_sample = SecondsOf([&] {
                          for (const int view : views.fitted)
                            static_cast<void>(source.RenderPrimal(view, halves.a));
                        }) /
                        (count * halves.a.spp);
  ProblemSize again;
  const double of_step = measure(Nudged(values, set), few, again);
  times.step = count * std::max(0.0, of_step - of_few);
  return measured;
}

/// From the first to the last number of samples: light comes to a pixel from ever more places.
void GrowWithSamples(const MeasuredViews& measured, int first, int last, ProblemSize& size) {
  const double more = static_cast<double>(last) / first;
  const double between = std::log(static_cast<double>(measured.more) / measured.few);
  const auto grow = [&](double of_few, double of_more, double& figure) {
    if (!(of_few > 0.0) || !(of_more > of_few)) return;
    figure *= std::pow(more, std::min(1.0, std::log(of_more / of_few) / between));
  };
  for (double ProblemSize::*figure :
       {&ProblemSize::largest_view_bytes, &ProblemSize::sparse_gram_bytes}) {
    grow(measured.of_few.*figure, measured.of_more.*figure, size.*figure);
  }
  for (const auto figure : kRootFigures) {
    grow(measured.of_few.roots.*figure, measured.of_more.roots.*figure, size.roots.*figure);
  }
}

struct ViewCounts {
  double fitted = 0.0, all = 0.0;
};

double RoundSeconds(const ViewSeconds& times, const ViewCounts& counts, int spp) {
  const double validation =
      (counts.all - counts.fitted) * std::min(spp, kValidationSpp) * times.render_sample;
  return times.step + counts.fitted * times.Round(spp, 1) + validation;
}

/// Of a stage by its plan for photos `reduced` times as large as those of `sizes` and
/// `smallest_side`.
StageTimes ForecastTimes(const FitSpec& spec,
                         int stage_index,
                         const StagePlan& plan,
                         const ViewCounts& counts,
                         const SizedSeconds& sizes,
                         double reduced,
                         int smallest_side,
                         LinearSolverKind solver) {
  StageTimes stage_times;
  const StageSpec& stage = plan.stage;
  for (const LevelPlan& level : plan.levels) {
    const ViewSeconds times = sizes.At(std::pow(reduced * level.scale / stage.image_scale, 2));
    for (int round = 0; round < level.most_rounds; ++round) {
      stage_times.most_s += RoundSeconds(times, counts, MostSamples(plan, level, round));
    }
    for (int round = 0; round < level.likely_rounds; ++round) {
      const double seconds = RoundSeconds(times, counts, LikelySamples(plan, level, round));
      if (&level == &plan.levels.front() && round == 0) stage_times.first_round_s = seconds;
      stage_times.likely_s += seconds;
    }
  }
  const StageSpec& last = spec.stages.back();
  const double last_pixels = std::pow(last.image_scale / stage.image_scale, 2);
  const bool is_last = stage_index + 1 == static_cast<int>(spec.stages.size());
  const double side_px = reduced * last.image_scale * smallest_side;
  const ViewSeconds times = sizes.At(reduced * reduced);
  const int draft = FitEvaluation::DraftSpp(side_px);
  const int pictures =
      (is_last ? FitEvaluation::SppOfPictures(side_px) : draft) + (stage_index == 0 ? draft : 0);
  double end = times.render_sample * (kNumCandidates * FitEvaluation::kFirstSpp * counts.fitted +
                                      pictures * last_pixels * counts.all);
  if (solver == LinearSolverKind::kSparseGram) {  // standard errors
    const LevelPlan& finest = plan.levels.back();
    end += counts.fitted * times.Round(LikelySamples(plan, finest, finest.likely_rounds - 1), 0);
  }
  stage_times.likely_s += end;
  stage_times.most_s += end;
  return stage_times;
}

/// A stage's problem with photos of some size, some of which are fitted.
struct Probe {
  Probe(const renderer::Scene& scene,
        const ObservationSet& observations,
        const FitSpec& spec,
        const StageSpec& stage,
        double scale)
      : all(ListViews(observations)), views(all) {
    views.fitted = SampleViews(all.fitted);
    for (const View& view : observations.views) {
      views.levels.emplace_back(view, observations, scale);
      cameras.push_back(views.levels.back().camera());
    }
    refined = SceneOfLevel(scene, spec, stage.free, views, scale).scene;
    exposure = MakeExposureModel(refined, spec.exposure);
    set = std::make_unique<ParameterSet>(refined, spec.unknowns, stage.free, all.fitted, exposure);
  }
  [[nodiscard]] std::unique_ptr<SceneImageSource> MakeSource(const FitSpec& spec) const {
    return std::make_unique<SceneImageSource>(
        refined, set->layout(), cameras, spec.estimators, nullptr);
  }

  FitViews all;  ///< without images
  FitViews views;
  std::vector<renderer::Camera> cameras;
  renderer::Scene refined;
  ExposureModel exposure;
  std::unique_ptr<ParameterSet> set;
};

// Of a photo that is linearised: larger ones are halved. Rounds of a surface cost by the pixel, and
// its mesh follows the pixels' size. Where nothing does, smaller photos see more of it by a pixel.
constexpr double kMeasuredPixels = 5e4;
constexpr double kMeasuredPixelsOfFixed = 1e6;

double MeasuredScale(const ObservationSet& observations, double scale, double most_pixels) {
  double pixels = 0.0;
  for (const View& view : observations.views) {
    pixels = std::max(pixels, scale * scale * view.photo.width() * view.photo.height());
  }
  for (; pixels > most_pixels; pixels *= 0.25) scale *= 0.5;
  return scale;
}

LinearSolverChoice SolverOf(LinearSolverChoice choice, std::size_t num_scalars) {
  if (ImageProblem::FormsNormalEquations(choice, num_scalars)) return LinearSolverChoice::kGram;
  if (ImageProblem::FormsSparseNormalEquations(choice, num_scalars)) {
    return LinearSolverChoice::kSparseGram;
  }
  return choice;
}

/// With the level's first and last samples. `options`: of the stage's last size.
template <class Samples>
ViewSeconds SecondsOfLevel(const renderer::Scene& scene,
                           const ObservationSet& observations,
                           const FitSpec& spec,
                           const StagePlan& plan,
                           const LevelPlan& level,
                           ImageProblemOptions options,
                           Samples samples_of) {
  const Probe probe(scene, observations, spec, plan.stage, level.scale);
  const std::unique_ptr<SceneImageSource> source = probe.MakeSource(spec);
  const std::vector<double> values = probe.set->layout().Gather(probe.refined);
  const int few = LikelySamples(plan, level, 0);
  const int more = LikelySamples(plan, level, std::max(0, level.likely_rounds - 1));
  options.linear_solver = SolverOf(spec.linear_solver, probe.set->NumScalars());
  options.samples = samples_of(few);
  ImageProblem(*source, probe.views, *probe.set, options).Linearize(values);
  return MeasureViews(*source,
                      probe.views,
                      *probe.set,
                      options,
                      values,
                      few,
                      std::max(kMoreSamples * few, std::min(more, kMostSamples)),
                      samples_of,
                      ForecastParts::kMemoryAndTimes)
      .seconds;
}

/// As a stage goes whose start has this share of noise in the residual; of few unknowns that does
/// not tell.
StagePlan ShortenedByNoise(const StagePlan& usual, double noise) {
  if (usual.kind.few) return usual;
  StagePlan plan = usual;
  const LevelNoise of_last{kNoiseAfterStart * noise, usual.levels.back().scale};
  for (std::size_t i = 0; i < plan.levels.size(); ++i) {
    plan.levels[i].likely_rounds = LikelyRounds(usual, i, of_last);
  }
  return plan;
}

/// From photos of one size to those of `pixels` times as many, with `unknowns` times the numbers.
void Enlarge(double pixels, double unknowns, ProblemSize& size) {
  size.num_scalars *= unknowns;
  size.largest_view_bytes *= pixels;
  size.sparse_gram_bytes *= unknowns;
  size.sparse_gram_seen *= unknowns;
  for (const auto figure : kRootFigures) {
    size.roots.*figure *= pixels;
  }
}

void CountPriors(const renderer::Scene& scene,
                 const FitSpec& spec,
                 const Probe& probe,
                 ProblemSize& size) {
  const ParameterSet& set = *probe.set;
  for (const auto& terms :
       {BuildPriorTerms(
            scene, probe.refined, spec.unknowns, set, probe.exposure, probe.views.num_channels),
        BuildProximalTerms(
            probe.refined, spec.unknowns, set, set.layout().Gather(probe.refined), 1.0)}) {
    size.num_prior_terms += static_cast<double>(terms.size());
    for (const PriorTerm& term : terms) {
      size.prior_blocks += static_cast<double>(term.blocks.size());
    }
  }
}

/// Bytes of the photos and, in `pixels`, how many of the fitted ones count.
double BytesOfImages(const ObservationSet& observations,
                     const FitViews& views,
                     const LossSpec& loss,
                     bool uses_gram,
                     double& pixels) {
  double bytes = 0.0;
  for (std::size_t i = 0; i < views.levels.size(); ++i) {
    const PackedLevel& level = views.levels[i];
    if (observations.views[i].validation) {
      bytes += static_cast<double>(level.MemoryBytes());
      continue;
    }
    for (const float weight : level.ColorWeight().data) pixels += static_cast<double>(weight);
    bytes += ImageProblem::BytesOfView(level, loss, uses_gram);
  }
  return bytes;
}

}  // namespace

MemoryItem LoadedMemory() {
  renderer::ReturnFreedMemory();
  return {"scene and photos as loaded", renderer::ProcessMemory("VmRSS:")};
}

StageMemory ForecastStage(const renderer::Scene& scene,
                          const ObservationSet& observations,
                          const FitSpec& spec,
                          int stage,
                          const MemoryItem& loaded,
                          ForecastParts parts) {
  const StageSpec& stage_spec = spec.stages[static_cast<std::size_t>(stage)];
  const double scale = stage_spec.image_scale;
  const Probe whole(scene, observations, spec, stage_spec, scale);
  const ParameterSet& set = *whole.set;
  const std::vector<int>& fitted = whole.all.fitted;
  renderer::ReturnFreedMemory();
  const double before = renderer::ProcessMemory("VmRSS:");
  std::unique_ptr<SceneImageSource> source = whole.MakeSource(spec);
  const double states_bytes = kSceneCopies * BytesOfValues(set.layout());
  const double scene_bytes = renderer::ProcessMemory("VmRSS:") - before + states_bytes;

  // The size of normal equations does not depend on what the pixels see.
  const bool few = ImageProblem::FormsNormalEquations(spec.linear_solver, set.NumScalars());
  double measured_scale = scale;
  std::unique_ptr<Probe> smaller;
  const auto measure_within = [&](double most_pixels) {
    measured_scale = MeasuredScale(observations, scale, most_pixels);
    smaller.reset();
    if (measured_scale < scale) {
      smaller = std::make_unique<Probe>(scene, observations, spec, stage_spec, measured_scale);
      source = smaller->MakeSource(spec);
    }
  };
  measure_within(kMeasuredPixels);
  if (smaller && !few && smaller->set->NumScalars() == set.NumScalars()) {
    measure_within(kMeasuredPixelsOfFixed);
    if (!smaller) source = whole.MakeSource(spec);
  }
  const Probe& probe = smaller ? *smaller : whole;
  const double more_pixels = std::pow(scale / measured_scale, 2);
  const auto num_scalars = static_cast<double>(set.NumScalars());
  ImageProblemOptions options;
  options.loss = spec.loss;
  options.linear_solver = SolverOf(spec.linear_solver, set.NumScalars());
  options.max_memory_bytes = spec.max_memory_bytes;
  options.expected_views = fitted.size();
  const int spp = few ? 2 : stage_spec.samples.Spp();
  const auto samples_of = [&](int num) {
    return MakeHalves(spec.seed,
                      stage,
                      1,
                      SampleUse::kFit,
                      BudgetOfRound(stage_spec.samples, num, kUsualSplit, spec.estimators));
  };
  options.samples = samples_of(spp);
  if (!stage_spec.samples.HasAll() && set.layout().AnyKind(renderer::MovesGeometry)) {
    options.num_measured = std::min(kMeasuredViews, probe.views.fitted.size());
  }
  const std::vector<double> values = probe.set->layout().Gather(probe.refined);
  bool uses_gram = false, uses_sparse_gram = false;
  double noise = 0.0;
  ProblemSize size;
  {
    ImageProblem problem(*source, probe.views, *probe.set, options);
    problem.Linearize(values);
    noise = RelativeNoise(problem.costs()) *
            std::sqrt(static_cast<double>(spp) / StageBudget::kUsualSpp);
    uses_gram = problem.UsesGram();
    uses_sparse_gram = problem.UsesSparseGram();
    size = SizeOfAll(problem.sizes(), fitted.size(), probe.set->NumBlocks());
  }
  double pixels = 0.0;
  size.images_bytes = BytesOfImages(observations, whole.views, spec.loss, uses_gram, pixels);
  const int side = SmallestSide(observations);
  const StagePlan plan =
      PlanStage(stage_spec, KindOfStage(scene, spec, stage, set, side), side, pixels);
  for (std::size_t i = 0; uses_gram && i < plan.levels.size(); ++i) {
    const double share = plan.levels[i].scale / stage_spec.image_scale;
    size.row_history_bytes = std::max(size.row_history_bytes,
                                      RoundSums::BytesOfRows(whole.views,
                                                             share * share,
                                                             static_cast<std::size_t>(num_scalars),
                                                             spec.max_memory_bytes));
  }
  const int last_spp =
      LikelySamples(plan, plan.levels.back(), plan.levels.back().likely_rounds - 1);
  MeasuredViews measured;
  if (num_scalars > 0.0 && (!few || parts == ForecastParts::kMemoryAndTimes)) {
    const int more = std::max(kMoreSamples * spp, few ? 0 : std::min(last_spp, kMostSamples));
    measured = MeasureViews(
        *source, probe.views, *probe.set, options, values, spp, more, samples_of, parts);
    if (!few) GrowWithSamples(measured, spp, last_spp, size);
  }
  Enlarge(
      more_pixels, num_scalars / std::max(1.0, static_cast<double>(probe.set->NumScalars())), size);
  CountPriors(scene, spec, whole, size);

  StageMemory memory;
  memory.num_scalars = num_scalars;
  memory.num_scalars_at_start = static_cast<double>(
      ParameterSet(
          scene, spec.unknowns, stage_spec.free, fitted, MakeExposureModel(scene, spec.exposure))
          .NumScalars());
  memory.jacobian_bytes = JacobianBytes(size, uses_gram);
  if (uses_gram || uses_sparse_gram) {
    memory.solver = uses_gram ? LinearSolverKind::kGram : LinearSolverKind::kSparseGram;
  } else {
    memory.solver = SolverOfRows(spec.linear_solver, size, spec.max_memory_bytes);
  }
  memory.items = ForecastMemory(size, memory.solver);
  memory.items.insert(
      memory.items.begin(),
      {loaded, {"scenes", scene_bytes}, {"checkpoint as it is written", states_bytes}});
  if (num_scalars > 0.0 && parts == ForecastParts::kMemoryAndTimes) {
    ViewSeconds last = measured.seconds;
    for (const auto figure : kViewFigures) {
      // Surfaces have as many triangles as there are pixels for.
      if (figure != &ViewSeconds::step || !few) last.*figure *= more_pixels;
    }
    SizedSeconds sizes{0.0, {}, last};
    const LevelPlan& first = plan.levels.front();
    if (const double small_scale = std::min(first.scale, measured_scale); small_scale < scale) {
      sizes.small_pixels = std::pow(small_scale / scale, 2);
      sizes.small =
          small_scale < measured_scale
              ? SecondsOfLevel(scene, observations, spec, plan, first, options, samples_of)
              : measured.seconds;
    }
    const ViewCounts counts{static_cast<double>(fitted.size()),
                            static_cast<double>(observations.views.size())};
    const auto times_of = [&](const StagePlan& of, double reduced) {
      return ForecastTimes(
          spec, stage, ShortenedByNoise(of, noise), counts, sizes, reduced, side, memory.solver);
    };
    memory.times = times_of(plan, 1.0);
    memory.likely_half_size_s =
        times_of(PlanStage(stage_spec, plan.kind, side / 2, 0.25 * pixels), 0.5).likely_s;
  }
  return memory;
}

void RequireMemory(const StageMemory& memory, const std::string& stage, double max_bytes) {
  if (max_bytes <= 0.0 || TotalBytes(memory.items) <= max_bytes) return;
  throw MemoryErrorOf("stage '" + stage + "'", memory.solver, memory.items, max_bytes);
}

std::vector<StageMemory> ForecastStages(const renderer::Scene& scene,
                                        const ObservationSet& observations,
                                        const FitSpec& spec,
                                        ForecastParts parts) {
  const MemoryItem loaded = LoadedMemory();
  std::vector<StageMemory> stages;
  for (std::size_t stage = 0; stage < spec.stages.size(); ++stage) {
    stages.push_back(
        ForecastStage(scene, observations, spec, static_cast<int>(stage), loaded, parts));
    RequireMemory(stages.back(), spec.stages[stage].name, spec.max_memory_bytes);
  }
  return stages;
}

}  // namespace pathfit::optim
