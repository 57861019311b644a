#include "optim/round/held_out_cameras.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <vector>

#include "optim/problem/camera_guard.h"
#include "optim/problem/image_problem.h"
#include "optim/round/round_policy.h"
#include "optim/solver/trust_region_solver.h"

namespace pathfit::optim {
namespace {

// Of six unknowns that a whole photo tells: damps what it does not.
constexpr double kRadius = 100.0;

bool IsOfPlace(renderer::ParameterKind kind) {
  return kind == renderer::ParameterKind::kCameraPosition ||
         kind == renderer::ParameterKind::kCameraRotation;
}

/// Of the stage, what a held-out view's own photo may tell of its camera; none unless a place is
/// free. (What is of one view alone cannot be free while that is held out.)
std::vector<int> FreeOfCameras(const FitSpec& spec, const StageSpec& stage) {
  std::vector<int> free;
  bool any_place = false;
  for (const int index : stage.free) {
    const UnknownSpec& unknown = spec.unknowns[static_cast<std::size_t>(index)];
    const bool is_place = IsOfPlace(unknown.kind);
    if (unknown.hold || unknown.object >= 0 || !(is_place || IsOfExposure(unknown.kind))) continue;
    any_place |= is_place;
    free.push_back(index);
  }
  return any_place ? free : std::vector<int>();
}

/// Where a view's photo says that its camera is, from where it is in `scene`.
void MoveCamera(const StageContext& context,
                const FitEvaluation& evaluation,
                const RoundReport& round,
                double unexplained,
                const std::vector<int>& free,
                int view,
                renderer::Scene& scene) {
  const std::vector<int> only{view};
  const ParameterSet set(scene, context.spec.unknowns, free, only, context.exposure);
  const std::vector<PriorTerm> priors = BuildPriorTerms(context.start,
                                                        scene,
                                                        context.spec.unknowns,
                                                        set,
                                                        context.exposure,
                                                        context.views.num_channels,
                                                        unexplained);
  const std::unique_ptr<SceneImageSource> source =
      evaluation.MakeSource(scene, set.layout(), context.views);
  ImageProblemOptions options;
  options.loss = context.spec.loss;
  options.linear_solver = LinearSolverChoice::kGram;
  options.samples = MakeHalves(
      context.spec.seed, context.stage, round.round, SampleUse::kValidation, round.samples);
  options.fitted = &only;
  ImageProblem problem(*source, context.views, set, options);
  const std::vector<double> theta = set.ThetaFromValues(set.layout().Gather(scene));
  const std::vector<double> values = set.ValuesFromTheta(theta);
  problem.Linearize(values);
  const CameraGuard cameras(scene, set, values);
  SolveOptions solve;
  solve.radius = kRadius;
  solve.restrain = [&](std::vector<double>& trial) { return cameras.Restrain(trial); };
  const SolveOutcome outcome = SolveRound(problem, priors, {}, theta, solve);
  if (outcome.accepted) set.layout().Scatter(set.ValuesFromTheta(outcome.theta), scene);
}

}  // namespace

bool FreesCameras(const FitSpec& spec, const StageSpec& stage) {
  return !FreeOfCameras(spec, stage).empty();
}

void MoveHeldOutCameras(const StageContext& context,
                        const FitEvaluation& evaluation,
                        const RoundReport& round,
                        FitState& state) {
  const StageSpec& stage = context.spec.stages[static_cast<std::size_t>(context.stage)];
  const std::vector<int> free = FreeOfCameras(context.spec, stage);
  const double unexplained = std::max(kGaussianResidual, state.unexplained);
  for (const int view : context.views.validation) {
    MoveCamera(context, evaluation, round, unexplained, free, view, state.scene);
  }
}

}  // namespace pathfit::optim
