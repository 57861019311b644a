#include "optim/round/fit.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "optim/checkpoint/checkpoint.h"
#include "optim/round/evaluation.h"
#include "optim/round/mesh_levels.h"
#include "optim/round/persistence.h"
#include "optim/round/round_policy.h"
#include "optim/round/round_runner.h"
#include "renderer/core/error.h"
#include "renderer/derivative/derivative_limits.h"

namespace pathfit::optim {
namespace {

std::vector<int> Range(std::size_t count) {
  std::vector<int> indices(count);
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

ExposureModel MakeExposureModel(const renderer::Scene& scene, const FitSpec& spec) {
  ExposureModel exposure{{}, spec.exposure};
  for (const renderer::Camera& sensor : scene.sensors) {
    exposure.start_gains.push_back(sensor.gain);
  }
  return exposure;
}

bool HasKind(const ParameterSet& set, renderer::ParameterKind kind) {
  const auto& groups = set.layout().groups();
  return std::any_of(
      groups.begin(), groups.end(), [kind](const auto& group) { return group.kind == kind; });
}

bool AnyView(const ObservationSet& observations, bool validation) {
  return std::any_of(observations.views.begin(),
                     observations.views.end(),
                     [validation](const View& view) { return view.validation == validation; });
}

void Validate(const renderer::Scene& start,
              const ObservationSet& observations,
              const FitSpec& spec) {
  if (start.sensors.size() != observations.views.size()) {
    throw renderer::SceneError("the scene has " + std::to_string(start.sensors.size()) +
                               " sensors for " + std::to_string(observations.views.size()) +
                               " views; they must correspond one to one");
  }
  if (!AnyView(observations, false)) {
    throw renderer::SceneError("every view is held out for validation: there is nothing to fit to");
  }
  if (spec.stages.empty()) {
    throw renderer::SceneError("the fit has no stages");
  }
  for (const UnknownSpec& unknown : spec.unknowns) {
    const bool of_one_view =
        renderer::TraitsOf(unknown.kind).list == renderer::ObjectList::kSensors && !unknown.hold &&
        unknown.object >= 0 && static_cast<std::size_t>(unknown.object) < observations.views.size();
    if (of_one_view && observations.views[static_cast<std::size_t>(unknown.object)].validation) {
      throw renderer::SceneError("'" + unknown.name +
                                 "' cannot be fitted: its view is held out for validation");
    }
  }
}

/// The stages of a fit in progress. What each step of a stage leaves is in the state, which is
/// written after it; reports and candidates are FitEvaluation's.
class FitDriver {
 public:
  FitDriver(const renderer::Scene& start,
            const ObservationSet& observations,
            const FitSpec& spec,
            FitObserver& observer,
            const FitControls& controls)
      : start_(start),
        spec_(spec),
        observer_(observer),
        controls_(controls),
        exposure_(MakeExposureModel(start, spec)),
        all_(start,
             spec.unknowns,
             Range(spec.unknowns.size()),
             Range(start.sensors.size()),
             exposure_),
        fits_exposure_(HasKind(all_, renderer::ParameterKind::kExposure)),
        evaluation_(observations, spec, exposure_, fits_exposure_, controls.cancel),
        session_start_(std::chrono::steady_clock::now()) {
    state_.fingerprint = FitFingerprint(spec, all_, observations);
    if (controls.resume) {
      ValidateState(*controls.resume, spec, state_.fingerprint);
      state_ = *controls.resume;
      earlier_wall_s_ = state_.wall_s;
    }
    if (fits_exposure_ && AnyView(observations, true)) {
      observer_.OnMessage(
          "assumption: the gain of each held-out view is estimated from its own photo, one number "
          "per view; nothing else of it enters the fit");
    }
    for (const std::string& limit : renderer::DerivativeLimits(start_, all_.layout())) {
      observer_.OnWarning("not in the derivative: " + limit);
    }
  }

  FitResult Run() {
    try {
      if (!controls_.resume) {
        state_.scene = start_;
        StageReport report;
        report.stage = report.kept = "start";
        evaluation_.ViewsAt(spec_.stages.back().image_scale);
        Report(std::move(report), evaluation_.Samples(0, spec_.stages.back()));
        BeginStage();
      }
      while (state_.stage < static_cast<int>(spec_.stages.size()) && RunStage()) {
        ++state_.stage;
        BeginStage();
        SaveCheckpoint();
      }
    } catch (const renderer::Cancelled&) {
      result_.status = FitStatus::kCancelled;
    }
    result_.scene = std::move(state_.scene);
    result_.rounds = state_.step;
    result_.wall_s = WallSeconds();
    return std::move(result_);
  }

 private:
  /// A scene that may end the stage.
  struct Candidate {
    std::string name;
    renderer::Scene scene;
  };
  /// The free unknowns of the stage and their priors, for scenes of the same shapes.
  struct Model {
    ParameterSet set;
    std::vector<PriorTerm> priors;
  };

  [[nodiscard]] double WallSeconds() const {
    const std::chrono::duration<double> session = std::chrono::steady_clock::now() - session_start_;
    return earlier_wall_s_ + session.count();
  }

  [[nodiscard]] Model MakeModel(const renderer::Scene& scene,
                                const StageSpec& stage,
                                const FitViews& views) const {
    ParameterSet set(scene, spec_.unknowns, stage.free, views.fitted, exposure_);
    std::vector<PriorTerm> priors =
        BuildPriorTerms(start_, scene, spec_.unknowns, set, exposure_, views.num_channels);
    return {std::move(set), std::move(priors)};
  }

  void BeginStage() {
    state_.round = 0;
    state_.radius_factor = 1.0;
    state_.damping = kStartDamping;
    state_.rejected_in_row = 0;
    state_.costs.clear();
    state_.model = QuadraticModel();
    state_.average = {};
    if (state_.stage < static_cast<int>(spec_.stages.size())) {
      const StageSpec& stage = spec_.stages[static_cast<std::size_t>(state_.stage)];
      MeshLevels levels = RefineMeshes(std::move(state_.scene),
                                       spec_.unknowns,
                                       stage.free,
                                       evaluation_.ViewsAt(stage.image_scale));
      state_.scene = std::move(levels.scene);
      for (const std::string& message : levels.messages) {
        observer_.OnMessage("stage '" + stage.name + "': " + message);
      }
    }
    state_.stage_start = state_.scene;
  }

  /// False when the time limit ended it.
  bool RunStage() {
    const StageSpec& stage = spec_.stages[static_cast<std::size_t>(state_.stage)];
    const FitViews& views = evaluation_.ViewsAt(stage.image_scale);
    // Where rounds have changed shapes, the units of priors are those of the present ones.
    std::optional<renderer::Scene> reshaped;
    if (!SameShapes(state_.stage_start, state_.scene)) {
      reshaped = state_.scene;
    }
    const renderer::Scene& reference = reshaped ? *reshaped : state_.stage_start;
    const Model model = MakeModel(reference, stage, views);
    bool in_time = true;
    std::string failure;
    if (model.set.NumScalars() == 0) {
      observer_.OnMessage("stage '" + stage.name + "' frees nothing and is skipped");
    } else {
      in_time = RunRounds(stage, views, model, failure);
    }
    StageReport report;
    report.stage = stage.name;
    report.rounds = state_.round;
    report.stop_reason = in_time ? StopReason(stage, state_) + failure : "time limit";
    if (!in_time) {
      result_.status = FitStatus::kTimeLimit;
    }
    const SampleHalves samples = evaluation_.Samples(state_.stage, stage);
    KeepBest(stage, views, reference, model, samples, report);
    Report(std::move(report), samples);
    return in_time;
  }

  /// Runs the rounds that are left. False when the time limit leaves no room for another one.
  /// `failure`: what the solver said if no step was accepted in the end.
  bool RunRounds(const StageSpec& stage,
                 const FitViews& views,
                 const Model& model,
                 std::string& failure) {
    const auto source = evaluation_.MakeSource(state_.scene, model.set.layout(), views);
    const StageContext context{
        spec_, state_.stage, views, model.set, exposure_, model.priors, fits_exposure_};
    double round_s = 0.0;
    while (StopReason(stage, state_).empty()) {
      if (controls_.cancel != nullptr && controls_.cancel->load()) {
        throw renderer::Cancelled();
      }
      const double before = WallSeconds();
      if (spec_.time_limit_s > 0.0 && before - earlier_wall_s_ + round_s > spec_.time_limit_s) {
        return false;
      }
      RoundReport report = RunRound(context, *source, state_);
      report.wall_s = WallSeconds();
      round_s = report.wall_s - before;
      failure = report.solver_failure.empty() ? "" : "; the solver: " + report.solver_failure;
      if (!failure.empty()) {
        observer_.OnWarning("round " + std::to_string(report.step) + ": no step" + failure);
      }
      // First the report: a resumed run drops rounds reported after its checkpoint, but cannot
      // bring back missing ones.
      observer_.OnRound(report);
      SaveCheckpoint();
    }
    return true;
  }

  [[nodiscard]] std::vector<Candidate> StageCandidates(const ParameterSet& set) const {
    std::vector<Candidate> candidates;
    if (state_.round > 1 && SameShapes(state_.average.newer.scene, state_.scene)) {
      candidates.push_back({"averaged", AverageIterate(state_.average, set).scene});
    }
    candidates.push_back({"last", state_.scene});
    candidates.push_back({"start", state_.stage_start});
    if (state_.stage > 0 && state_.stage + 1 == static_cast<int>(spec_.stages.size())) {
      candidates.push_back({"start of the run", start_});
    }
    return candidates;
  }

  /// Moves the state to the candidate that costs least on `samples`.
  void KeepBest(const StageSpec& stage,
                const FitViews& views,
                const renderer::Scene& reference,
                const Model& model,
                const SampleHalves& samples,
                StageReport& report) {
    std::vector<Candidate> candidates = StageCandidates(model.set);
    std::size_t best = 0;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const renderer::Scene& scene = candidates[i].scene;
      std::optional<Model> other;
      if (!SameShapes(scene, reference)) {
        other = MakeModel(scene, stage, views);
      }
      const Model& own = other ? *other : model;
      const double priors =
          PriorCost(own.priors, own.set, own.set.ThetaFromValues(own.set.layout().Gather(scene)));
      const auto source = evaluation_.MakeSource(scene, {}, views);
      const double cost = EvaluateCost(*source, views, spec_.loss, samples, priors).Total();
      if (candidates[i].name == "start") {
        report.cost_before = cost;
      }
      if (i == 0 || cost < report.cost_after) {
        best = i;
        report.cost_after = cost;
      }
    }
    state_.scene = std::move(candidates[best].scene);
    report.kept = candidates[best].name;
  }

  void Report(StageReport report, const SampleHalves& samples) {
    const ReportImages images = evaluation_.Report(samples, state_.scene, report);
    report.wall_s = WallSeconds();
    observer_.OnStage(report, images.rendered, images.photos);
    result_.stages.push_back(std::move(report));
  }

  void SaveCheckpoint() {
    ++state_.sequence;
    state_.wall_s = WallSeconds();
    if (!controls_.checkpoint_folder.empty()) {
      WriteCheckpoint(controls_.checkpoint_folder, {start_, spec_.unknowns}, state_);
    }
  }

  const renderer::Scene& start_;
  const FitSpec& spec_;
  FitObserver& observer_;
  const FitControls& controls_;
  ExposureModel exposure_;
  ParameterSet all_;  ///< every unknown that is not held
  bool fits_exposure_;
  FitEvaluation evaluation_;
  FitState state_;
  FitResult result_;
  double earlier_wall_s_ = 0.0;  ///< of sessions before this one
  std::chrono::steady_clock::time_point session_start_;
};

}  // namespace

FitResult RunFit(const renderer::Scene& start,
                 const ObservationSet& observations,
                 const FitSpec& spec,
                 FitObserver& observer,
                 const FitControls& controls) {
  Validate(start, observations, spec);
  return FitDriver(start, observations, spec, observer, controls).Run();
}

}  // namespace pathfit::optim
