#include "optim/round/memory_forecast.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "optim/checkpoint/fit_state.h"
#include "optim/problem/fit_views.h"
#include "optim/problem/image_problem.h"
#include "optim/problem/scene_image_source.h"
#include "optim/round/exposure_gauge.h"
#include "optim/round/process_memory.h"
#include "optim/round/round_policy.h"
#include "optim/round/surface_levels.h"
#include "optim/solver/trust_region_solver.h"

namespace pathfit::optim {
namespace {

constexpr std::size_t kNumSampled = 4;  // views that are linearised

StageMemory ForecastStage(const renderer::Scene& scene,
                          const ObservationSet& observations,
                          const FitSpec& spec,
                          int stage) {
  const StageSpec& stage_spec = spec.stages[static_cast<std::size_t>(stage)];
  const double scale = stage_spec.image_scale;
  FitViews views = ListViews(observations);
  const std::vector<int> fitted = views.fitted;
  const std::size_t num_sampled = std::min(kNumSampled, fitted.size());
  views.fitted.clear();
  for (std::size_t i = 0; i < num_sampled; ++i) {
    views.fitted.push_back(fitted[i * fitted.size() / num_sampled]);
  }
  std::vector<renderer::Camera> cameras;
  for (std::size_t i = 0; i < observations.views.size(); ++i) {
    views.levels.emplace_back(observations.views[i], observations, scale);
    cameras.push_back(views.levels.back().camera());
  }

  const renderer::Scene refined = SceneOfLevel(scene, spec, stage_spec.free, views, scale).scene;
  const ExposureModel exposure = MakeExposureModel(refined, spec.exposure);
  const ParameterSet set(refined, spec.unknowns, stage_spec.free, fitted, exposure);
  SceneImageSource source(refined, set.layout(), cameras, spec.estimators, nullptr);
  ImageProblemOptions options;
  options.loss = spec.loss;
  options.linear_solver = spec.linear_solver;
  options.max_memory_bytes = spec.max_memory_bytes;
  options.expected_views = fitted.size();
  // The size of normal equations does not depend on what the pixels see.
  const int spp = ImageProblem::FormsNormalEquations(spec.linear_solver, set.NumScalars())
                      ? 2
                      : stage_spec.samples.spp;
  options.samples =
      MakeHalves(spec.seed,
                 stage,
                 1,
                 SampleUse::kFit,
                 BudgetOfRound(stage_spec.samples, spp, kStartSplit, spec.estimators));
  ImageProblem problem(source, views, set, options);
  problem.Linearize(set.layout().Gather(refined));
  ProblemSize size = problem.size();
  size.images_bytes = 0.0;
  for (std::size_t i = 0; i < views.levels.size(); ++i) {
    const PackedLevel& level = views.levels[i];
    size.images_bytes += observations.views[i].validation
                             ? static_cast<double>(level.MemoryBytes())
                             : ImageProblem::BytesOfView(level, problem.UsesGram());
  }

  StageMemory memory;
  memory.num_scalars = size.num_scalars;
  memory.solver = problem.UsesGram()
                      ? LinearSolverKind::kGram
                      : ChooseLinearSolver(spec.linear_solver, size, spec.max_memory_bytes);
  memory.items = ForecastMemory(size, memory.solver);
  return memory;
}

}  // namespace

std::vector<StageMemory> ForecastStages(const renderer::Scene& scene,
                                        const ObservationSet& observations,
                                        const FitSpec& spec) {
  const MemoryItem loaded = {"scene and photos as loaded", ProcessMemory("VmRSS:")};
  std::vector<StageMemory> stages;
  for (std::size_t stage = 0; stage < spec.stages.size(); ++stage) {
    stages.push_back(ForecastStage(scene, observations, spec, static_cast<int>(stage)));
    stages.back().items.insert(stages.back().items.begin(), loaded);
  }
  return stages;
}

}  // namespace pathfit::optim
