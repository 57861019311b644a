#include "optim/round/fit.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "optim/checkpoint/checkpoint.h"
#include "optim/problem/image_problem.h"
#include "optim/ranks/division.h"
#include "optim/ranks/ranks.h"
#include "optim/round/color_gauge.h"
#include "optim/round/evaluation.h"
#include "optim/round/exposure_gauge.h"
#include "optim/round/held_out_cameras.h"
#include "optim/round/mesh_levels.h"
#include "optim/round/other_starts.h"
#include "optim/round/persistence.h"
#include "optim/round/recorded_errors.h"
#include "optim/round/round_policy.h"
#include "optim/round/round_runner.h"
#include "optim/round/stage_plan.h"
#include "optim/round/surface_levels.h"
#include "optim/round/texel_fill.h"
#include "optim/solver/step_bounds.h"
#include "renderer/core/clock.h"
#include "renderer/core/error.h"
#include "renderer/core/indices.h"
#include "renderer/core/process_memory.h"
#include "renderer/derivative/derivative_limits.h"

namespace pathfit::optim {
namespace {

// Of a stage's last step: logarithms that would go farther are not told, and together they leave
// what the quadratic model holds for.
constexpr double kReachOfLogs = 0.1;

// How often a level looks for needles, and begins again without them.
constexpr int kRoundsPerLook = 5;
constexpr int kMostRestarts = 2;
constexpr double kMostRise = 4.0;  // of the cost: points that photos show cost more

// From another start, of the smallest photos.
constexpr int kRoundsOfTrial = 8;

// Of an object that may lie in the wrong valley: turned starts that rounds are run from, and what
// they cost at most, in what the level has come to. In the right valley they cost far more.
constexpr std::size_t kMostTurned = 3;
constexpr double kMostTurnedCost = 15.0;
constexpr double kExplainedCost = 0.05;  // of the level's first round: the valley is the right one
// Of the present end, for another one. Edges make few pixels differ by much, which would pass for
// noise where photos are so small.
constexpr double kClearlyLess = 0.8;

int CountMovingVertices(const renderer::Scene& scene, const renderer::ParameterLayout& layout) {
  std::size_t sum = 0;
  for (const renderer::ParameterGroup& group : layout.groups()) {
    if (group.kind == renderer::ParameterKind::kVertexPositions) {
      sum += scene.meshes[static_cast<std::size_t>(group.object)].mesh.positions.size();
    }
  }
  return static_cast<int>(sum);
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
        observations_(observations),
        spec_(spec),
        observer_(observer),
        controls_(controls),
        exposure_(MakeExposureModel(start, spec.exposure)),
        all_(start,
             spec.unknowns,
             renderer::AllIndices(spec.unknowns.size()),
             renderer::AllIndices(start.sensors.size()),
             exposure_),
        free_gains_(FreeGainsOf(spec.unknowns)),
        division_(controls.ranks, controls.cancel),
        evaluation_(observations, spec, exposure_, free_gains_, controls.cancel, division_),
        session_start_(renderer::Clock::now()) {
    state_.fingerprint = FitFingerprint(spec, all_, observations);
    if (controls.resume) {
      ValidateState(*controls.resume, spec, state_.fingerprint);
      state_ = *controls.resume;
      earlier_wall_s_ = state_.wall_s;
    }
    if (AnyView(observations, true)) {
      observer_.OnMessage(
          std::string("assumption: held-out photos tell when many unknowns gain no more") +
          (free_gains_ != FreeGains::kNone ? ", and the gains of their own view" : "") +
          (std::ranges::any_of(spec.stages,
                               [&](const StageSpec& stage) { return FreesCameras(spec, stage); })
               ? ", and the places of their own cameras"
               : "") +
          "; nothing else of them enters the fit");
    }
    for (const std::string& limit :
         renderer::DerivativeLimits(start_, all_.layout(), spec.estimators.form)) {
      observer_.OnLimit(limit);
    }
  }

  FitResult Run() {
    try {
      if (!division_.Share(controls_.resume.has_value())) {
        state_.scene = start_;
        MoveIntoBounds(spec_.unknowns, state_.scene);
        StageReport report;
        report.stage = report.kept = "start";
        evaluation_.SharedViewsAt(spec_.stages.back().image_scale);
        Report(std::move(report), DraftSpp(), nullptr);
        BeginStage();
      }
      ShareState();
      while (state_.stage < static_cast<int>(spec_.stages.size()) && RunStage()) {
        SaveStageEnd();
        const std::string& done = spec_.stages[static_cast<std::size_t>(state_.stage++)].name;
        BeginStage();
        SaveCheckpoint();
        if (done == controls_.stop_after) {
          result_.status = FitStatus::kStageReached;
          break;
        }
      }
    } catch (const renderer::Cancelled&) {
      if (!division_.IsFirst()) {
        throw;
      }
      result_.status = FitStatus::kCancelled;
    }
    result_.scene = std::move(state_.scene);
    result_.gauge = ReportGauge(spec_, exposure_, start_, result_.scene);
    result_.rounds = state_.step;
    result_.wall_s = WallSeconds();
    result_.standard_errors = std::move(state_.standard_errors);
    return std::move(result_);
  }

 private:
  /// A scene that may end the stage.
  struct Candidate {
    std::string name;
    renderer::Scene scene;
    bool is_start = false;
    double cost = 0.0;
  };
  /// The free unknowns of the stage and their priors, for scenes of the same shapes.
  struct Model {
    ParameterSet set;
    std::vector<PriorTerm> priors;
  };

  [[nodiscard]] double WallSeconds() const {
    return earlier_wall_s_ + renderer::SecondsSince(session_start_);
  }

  [[nodiscard]] Model MakeModel(const renderer::Scene& scene,
                                const StageSpec& stage,
                                const FitViews& views) const {
    ParameterSet set(scene, spec_.unknowns, stage.free, views.fitted, exposure_);
    std::vector<PriorTerm> priors = MakePriors(scene, set, views);
    return {std::move(set), std::move(priors)};
  }

  /// As strong as photos are left unexplained at present.
  [[nodiscard]] std::vector<PriorTerm> MakePriors(const renderer::Scene& scene,
                                                  const ParameterSet& set,
                                                  const FitViews& views) const {
    return BuildPriorTerms(start_,
                           scene,
                           spec_.unknowns,
                           set,
                           exposure_,
                           views.num_channels,
                           std::max(kGaussianResidual, state_.unexplained));
  }

  /// Whether a prior of the stage does.
  [[nodiscard]] bool FollowsTheUnexplained(const StageSpec& stage) const {
    return std::ranges::any_of(stage.free, [&](int index) {
      return spec_.unknowns[static_cast<std::size_t>(index)].log_smooth_weight > 0.0;
    });
  }

  void BeginStage() {
    state_.round = 0;
    state_.level = 0;
    state_.accepted = 0;
    state_.split = kStartSplit;
    state_.stage_start = state_.scene;  // before it is refined
    BeginLevel();
  }

  /// What rounds have learned of their level.
  static void ForgetRounds(FitState& state) {
    state.level_start = state.round;
    state.growths = 0;
    if (state.level == 0) {
      state.damping = kStartDamping;
    }
    state.rejected_in_row = 0;
    state.step_share = 1.0;
    state.costs.clear();
    state.held_out_costs.clear();
    state.promised_cost = 0.0;
    state.rounds = RoundSums();
    state.within_error = 0;
    state.still = 0;
    state.flat = 0;
    state.precise = false;
    state.average = {};
  }

  /// On the first rank; the others get the state that it leads to. `restarts`: of this level.
  void BeginLevel(int restarts = 0) {
    if (!division_.IsFirst()) {
      return;
    }
    const int growths = state_.growths;
    QuadraticModel coarse = std::exchange(state_.rounds, RoundSums()).model;
    ForgetRounds(state_);
    state_.restarts = restarts;
    if (state_.stage == static_cast<int>(spec_.stages.size())) {
      return;
    }
    const StageSpec& stage = spec_.stages[static_cast<std::size_t>(state_.stage)];
    const std::vector<double> scales = Scales();
    SceneLevel level = LevelAt(stage, scales);
    state_.scene = std::move(level.scene);
    state_.level_scene = state_.scene;
    const ParameterSet set = FreeSet(state_.scene, stage);
    // Where nothing moves, steps hold at any size of the photos, and so does what they have shown.
    const bool stands = state_.level > 0 && !MovesSomething(set);
    const bool goes_on = stands && IsFew(set);
    // A level's few samples would spoil texels that many have told.
    if (stands && !goes_on) state_.growths = growths;
    if (!goes_on) {
      state_.radius_factor = IsFew(set) ? kStartRadiusFactor : 1.0;
    } else if (coarse.NumScalars() == set.NumScalars()) {
      const auto l = static_cast<std::size_t>(state_.level);
      const double ratio = scales[l] / scales[l - 1];
      CarryToPhotosOfMorePixels(ratio * ratio, coarse);
      state_.rounds = RoundSums::Of(std::move(coarse));
    }
    for (const std::string& message : level.messages) {
      observer_.OnMessage("stage '" + stage.name + "': " + message);
    }
  }

  /// Of the present level.
  SceneLevel LevelAt(const StageSpec& stage, const std::vector<double>& scales) {
    const double scale = scales[static_cast<std::size_t>(state_.level)];
    return SceneOfLevel(state_.scene, spec_, stage.free, evaluation_.ViewsAt(scale), scale);
  }

  [[nodiscard]] ParameterSet FreeSet(const renderer::Scene& scene, const StageSpec& stage) const {
    return {
        scene, spec_.unknowns, stage.free, renderer::AllIndices(scene.sensors.size()), exposure_};
  }

  [[nodiscard]] bool IsFew(const ParameterSet& set) const {
    return ImageProblem::FormsNormalEquations(spec_.linear_solver, set.NumScalars());
  }

  static bool MovesSomething(const ParameterSet& set) {
    return set.layout().AnyKind(renderer::MovesGeometry);
  }

  /// Of the present stage, by the scene that it began with.
  [[nodiscard]] std::vector<double> Scales() const {
    const StageSpec& stage = spec_.stages[static_cast<std::size_t>(state_.stage)];
    const ParameterSet set = FreeSet(state_.stage_start, stage);
    if (set.NumScalars() == 0 && !Promotes(spec_, stage)) {
      return {stage.image_scale};  // and is skipped
    }
    const int side = SmallestSide(observations_);
    return ScalesOfStage(
        stage, KindOfStage(state_.stage_start, spec_, state_.stage, set, side), side);
  }

  /// False when the time limit ended it.
  bool RunStage() {
    const StageSpec& stage = spec_.stages[static_cast<std::size_t>(state_.stage)];
    const std::vector<double> scales = Scales();
    if (state_.level >= static_cast<int>(scales.size())) {
      throw renderer::IoError("the checkpoint is not one of this program: image level " +
                              std::to_string(state_.level) + " of " +
                              std::to_string(scales.size()));
    }
    ChooseStart(stage, scales.front());
    bool in_time = true;
    while (in_time && state_.level + 1 < static_cast<int>(scales.size())) {
      in_time = RunLevel(stage, scales);
      if (in_time) {
        if (state_.level == 0) LookAround(stage, scales.front());
        ++state_.level;
        BeginLevel();
        SaveCheckpoint();
      }
    }
    if (in_time) {
      in_time = RunLevel(stage, scales);
    }
    EndStage(stage, in_time);
    return in_time;
  }

  /// What units of priors are taken from.
  [[nodiscard]] const renderer::Scene& Reference() const {
    return SameShapes(state_.level_scene, state_.scene) ? state_.level_scene : state_.scene;
  }

  [[nodiscard]] StageContext ContextOf(const StageSpec& stage,
                                       double scale,
                                       const FitViews& views,
                                       const Model& model) {
    return {spec_,
            state_.stage,
            views,
            model.set,
            exposure_,
            start_,
            model.priors,
            free_gains_,
            scale,
            SampleFactor(stage,
                         scale,
                         views.num_channels / 3.0,
                         {.moves = MovesSomething(model.set), .few = IsFew(model.set)}),
            division_};
  }

  /// Where rounds from another start surely explain small photos better, the stage begins there.
  void ChooseStart(const StageSpec& stage, double scale) {
    if (state_.round > 0 || state_.level > 0) {
      return;
    }
    while (0.5 * scale * SmallestSide(observations_) >= kSmallestSideOfShapes) scale *= 0.5;
    const FitViews* views = nullptr;
    std::optional<renderer::Scene> end;  // of rounds from the start so far
    for (const int index : stage.free) {
      const UnknownSpec& unknown = spec_.unknowns[static_cast<std::size_t>(index)];
      for (const double value : OtherStarts(state_.scene, unknown, spec_.unknowns)) {
        if (division_.Share(IsLate())) {
          return;
        }
        if (views == nullptr) {
          views = &evaluation_.SharedViewsAt(scale);
          end = EndOfTrial(state_.scene, stage, scale, *views);
        }
        renderer::Scene start = StartingAt(state_.scene, unknown, value);
        renderer::Scene other = EndOfTrial(start, stage, scale, *views);
        if (!Compare({&*end, &other}, stage, *views, FitEvaluation::kMostSpp).IsSurelyWorse(0, 1)) {
          continue;
        }
        std::array<char, 80> text{};
        std::snprintf(
            text.data(), text.size(), "%.3g than at %.3g", value, StartOf(state_.scene, unknown));
        observer_.OnMessage("stage '" + stage.name + "': rounds of small photos end better where " +
                            unknown.name + " starts at " + text.data() +
                            ", and the stage begins there");
        state_.scene = state_.level_scene = std::move(start);
        end = std::move(other);
      }
    }
  }

  /// After the first level: where an object that is turned otherwise leads rounds of these photos
  /// to a surely better end, the stage goes on from there.
  void LookAround(const StageSpec& stage, double scale) {
    const FitViews& views = evaluation_.SharedViewsAt(scale);
    if (!IsFew(FreeSet(state_.scene, stage)) || state_.costs.empty() ||
        state_.costs.back() < kExplainedCost * state_.costs.front()) {
      return;
    }
    for (const int index : stage.free) {
      const UnknownSpec& unknown = spec_.unknowns[static_cast<std::size_t>(index)];
      const std::vector<renderer::Scene> starts = TurnedStarts(state_.scene, unknown);
      if (starts.empty()) continue;
      std::vector<const renderer::Scene*> scenes = {&state_.scene};
      for (const renderer::Scene& start : starts) scenes.push_back(&start);
      const std::vector<EvaluatedCost> costs =
          Compare(scenes, stage, views, FitEvaluation::kMostSpp).costs;
      const auto cost_of = [&](int start) {
        return costs[static_cast<std::size_t>(start) + 1].Total();
      };
      std::vector<int> order = renderer::AllIndices(starts.size());
      std::ranges::sort(order, {}, cost_of);
      order.resize(std::min(order.size(), kMostTurned));
      renderer::Scene best = state_.scene;
      bool found = false;
      for (const int i : order) {
        if (division_.Share(IsLate()) || !(cost_of(i) < kMostTurnedCost * costs[0].Total())) {
          break;
        }
        renderer::Scene end = EndOfTrial(starts[static_cast<std::size_t>(i)], stage, scale, views);
        const std::vector<EvaluatedCost> ends =
            Compare({&best, &end}, stage, views, FitEvaluation::kMostSpp).costs;
        if (ends[1].Total() < kClearlyLess * ends[0].Total()) {
          best = std::move(end);
          found = true;
        }
      }
      if (!found) continue;
      observer_.OnMessage("stage '" + stage.name + "': small photos are explained better with " +
                          unknown.name + " from another start, and the stage goes on from there");
      state_.scene = std::move(best);
    }
  }

  /// Where a few rounds of a coarse level lead to, which nothing else learns of.
  [[nodiscard]] renderer::Scene EndOfTrial(const renderer::Scene& start,
                                           const StageSpec& stage,
                                           double scale,
                                           const FitViews& views) {
    // As the first of two levels, which has its share of the rounds.
    constexpr int kLevels = 2;
    StageSpec trial_stage = stage;
    trial_stage.max_rounds = (kLevels + 1) * kRoundsOfTrial;
    FitState trial = state_;
    trial.round = trial.level = trial.accepted = 0;
    trial.split = kStartSplit;
    ForgetRounds(trial);
    trial.scene = trial.level_scene = start;
    const Model model = MakeModel(start, stage, views);
    trial.radius_factor = IsFew(model.set) ? kStartRadiusFactor : 1.0;
    const auto source = evaluation_.MakeSource(start, model.set.layout(), views);
    const StageContext context = ContextOf(stage, scale, views, model);
    while (trial.round < kRoundsOfTrial && StopReason(trial_stage, trial, kLevels).empty()) {
      ThrowIfCancelled();
      RunRound(context, *source, trial);
      ShareState(trial);
    }
    return std::move(trial.scene);
  }

  void ThrowIfCancelled() const {
    if (controls_.cancel != nullptr && controls_.cancel->load() && division_.IsFirst()) {
      throw renderer::Cancelled();
    }
  }

  /// Whether the time limit leaves no room for another round.
  [[nodiscard]] bool IsLate() const {
    return spec_.time_limit_s > 0.0 &&
           WallSeconds() - earlier_wall_s_ + round_s_ > spec_.time_limit_s;
  }

  /// False when the time limit ended it.
  bool RunLevel(const StageSpec& stage, const std::vector<double>& scales) {
    const double scale = scales[static_cast<std::size_t>(state_.level)];
    const FitViews& views = evaluation_.SharedViewsAt(scale);
    RoundsEnd end = RoundsEnd::kMended;
    while (end == RoundsEnd::kMended) {
      Model model = MakeModel(Reference(), stage, views);
      if (model.set.NumScalars() == 0) {
        observer_.OnMessage("stage '" + stage.name + "' frees nothing and is skipped");
        return true;
      }
      end = RunRounds(
          ContextOf(stage, scale, views, model), stage, NumLevels(stage, scales), model.priors);
    }
    return end == RoundsEnd::kDone;
  }

  void EndStage(const StageSpec& stage, bool in_time) {
    StageReport report;
    report.stage = stage.name;
    report.rounds = state_.round;
    report.stop_reason =
        in_time ? StopReason(stage, state_, NumLevels(stage, Scales())) + failure_ : "time limit";
    if (!in_time) {
      result_.status = FitStatus::kTimeLimit;
    }
    if (state_.round > 0 && state_.accepted == 0) {
      observer_.OnWarning("stage '" + stage.name +
                          "': no step was accepted, nothing has moved; its start may be far from "
                          "what the photos show, or nothing in them depends on what is free");
    }
    const FitViews& views = evaluation_.SharedViewsAt(stage.image_scale);
    ReportDivision(stage);
    MoveToMinimum(stage, views);
    ShareState();
    const bool told_by_few = KeepBest(stage, views, report);
    if (division_.IsFirst()) {  // which has all photos
      for (const std::string& message : FillUnseenTexels(spec_.unknowns, views, state_.scene)) {
        observer_.OnMessage("stage '" + stage.name + "': " + message);
      }
    }
    const Model model = MakeModel(state_.scene, stage, views);
    const renderer::MeshFolds folds = CountFolds(state_.scene, model.set.layout());
    report.folded_edges = folds.folded_edges;
    report.crossing_triangles = folds.crossing_triangles;
    ShareState();
    if (in_time && state_.accepted > 0) {
      const auto source = evaluation_.MakeSource(state_.scene, model.set.layout(), views);
      RecordErrorsOfMany(ContextOf(stage, stage.image_scale, views, model),
                         *source,
                         state_,
                         state_.standard_errors);
      ShareState();
    }
    const bool last = state_.stage + 1 == static_cast<int>(spec_.stages.size());
    const int spp = last ? FitEvaluation::SppOfPictures(SmallerSide()) : DraftSpp();
    // Few samples tell the candidates apart, but not what the one that is kept costs.
    const bool is_rough = told_by_few && spp > FitEvaluation::kFirstSpp &&
                          stage.image_scale == spec_.stages.back().image_scale;
    Report(std::move(report), spp, is_rough ? &stage : nullptr);
  }

  /// Why rounds end: the level is done, the time limit leaves no room for another one, or the
  /// scene has meshes of other shapes.
  enum class RoundsEnd { kDone, kTimeLimit, kMended };

  /// Runs the rounds that are left. `priors`: the context's.
  RoundsEnd RunRounds(const StageContext& context,
                      const StageSpec& stage,
                      int num_levels,
                      std::vector<PriorTerm>& priors) {
    const auto make_source = [&] {
      return evaluation_.MakeSource(state_.scene, context.set.layout(), context.views);
    };
    const bool moves_held_out = !context.views.validation.empty() && FreesCameras(spec_, stage);
    std::unique_ptr<SceneImageSource> source = make_source();
    renderer::ReturnFreedMemory();  // pieces as large as those of another level
    double unexplained = state_.unexplained;
    while (StopReason(stage, state_, num_levels).empty()) {
      ThrowIfCancelled();
      if (BeginAgain(context, stage, num_levels)) {
        return RoundsEnd::kMended;
      }
      const double before = WallSeconds();
      if (division_.Share(IsLate())) {
        return RoundsEnd::kTimeLimit;
      }
      RoundReport report = RunRound(context, *source, state_);
      bool mended = false;
      if (division_.IsFirst()) {
        if (moves_held_out) MoveHeldOutCameras(context, evaluation_, report, state_);
        mended = report.accepted && Mend(stage, context.views);
        EndRound(context, before, std::move(report));
      }
      SaveCheckpoint();
      if (division_.Share(mended)) {
        return RoundsEnd::kMended;
      }
      if (moves_held_out) source = make_source();  // which shows where those cameras are now
      if (state_.unexplained != unexplained && FollowsTheUnexplained(stage)) {
        unexplained = state_.unexplained;
        priors = std::vector<PriorTerm>();  // first: of many texels they are large
        priors = MakePriors(Reference(), context.set, context.views);
      }
    }
    return RoundsEnd::kDone;
  }

  /// What a round reports.
  void EndRound(const StageContext& context, double began, RoundReport report) {
    const renderer::MeshFolds folds = CountFolds(state_.scene, context.set.layout());
    report.moving_vertices = CountMovingVertices(state_.scene, context.set.layout());
    report.folded_edges = folds.folded_edges;
    report.crossing_triangles = folds.crossing_triangles;
    report.wall_s = WallSeconds();
    round_s_ = report.wall_s - began;
    failure_ = report.solver_failure.empty() ? "" : "; the solver: " + report.solver_failure;
    if (!failure_.empty()) {
      observer_.OnWarning("round " + std::to_string(report.step) + ": no step" + failure_);
    }
    // First the report: a resumed run drops rounds reported after its checkpoint, but cannot
    // bring back missing ones.
    observer_.OnRound(report);
  }

  /// New triangles where the last step has worn out the meshes. False: nowhere.
  bool Mend(const StageSpec& stage, const FitViews& views) {
    std::optional<renderer::Scene> mended =
        MendMeshes(state_.scene, spec_.unknowns, stage.free, views);
    if (!mended) {
      return false;
    }
    state_.scene = std::move(*mended);
    state_.level_scene = state_.scene;
    state_.rounds = RoundSums();  // of other unknowns
    return true;
  }

  /// Begins a level before the last again, without needles: where the first large steps have
  /// crumpled a coarse mesh its rounds gain little, and finer ones refine the crumples. Points that
  /// photos show are told from them by what it costs to go without. False: it goes on as it is.
  bool BeginAgain(const StageContext& context, const StageSpec& stage, int num_levels) {
    const int rounds = state_.RoundsOfLevel();
    if (rounds == 0 || rounds % kRoundsPerLook != 0 || state_.restarts >= kMostRestarts ||
        state_.level + 1 >= num_levels) {
      return false;
    }
    std::optional<renderer::Scene> blunted =
        BluntSceneOfLevel(state_.scene, spec_, stage.free, context.views, context.image_scale);
    if (!blunted) {
      return false;
    }
    const std::vector<EvaluatedCost> costs =
        Compare({&state_.scene, &*blunted}, stage, context.views, FitEvaluation::kFirstSpp).costs;
    if (costs[1].Total() > kMostRise * costs[0].Total()) {
      return false;
    }
    if (division_.IsFirst()) {
      observer_.OnMessage("stage '" + stage.name +
                          "': points one triangle wide, of which photos show nothing, are smoothed "
                          "away, and the level begins again");
      state_.scene = std::move(*blunted);
      BeginLevel(state_.restarts + 1);
    }
    SaveCheckpoint();
    return true;
  }

  /// Steps within their error are damped, so that they end on the side of the start: the last one
  /// goes the rest of the way, to what the rounds together say.
  void MoveToMinimum(const StageSpec& stage, const FitViews& views) {
    const Model model = MakeModel(Reference(), stage, views);
    const std::size_t n = model.set.NumScalars();
    if (state_.rounds.model.Empty() || state_.rounds.model.NumScalars() != n ||
        model.set.layout().AnyKind([](renderer::ParameterKind kind) {
          return kind == renderer::ParameterKind::kVertexPositions;
        })) {
      return;
    }
    std::vector<double> theta = model.set.ThetaFromValues(model.set.layout().Gather(state_.scene));
    std::vector<bool> free = model.set.InsideBounds(theta);
    const std::vector<double> hessian = PriorHessian(model.priors, model.set, theta);
    const std::vector<double> gradient = PriorGradient(model.priors, model.set, theta);
    std::vector<double> step;
    // What hardly anything tells goes where no model holds.
    for (bool goes_far = true; goes_far;) {
      step = FindMinimum(state_.rounds.model, theta, hessian, gradient, free).step;
      goes_far = false;
      for (std::size_t i = 0; i < n; ++i) {
        const auto [lower, upper] = ReachOfModel(model.set, theta[i], i);
        const double after = theta[i] + step[i];
        const bool leaves = after < lower || after > upper ||
                            (model.set.IsLog(i) && std::abs(step[i]) > kReachOfLogs);
        if (leaves) {
          free[i] = false;
          goes_far = true;
        }
      }
    }
    if (!(SignificanceOfStep(step, state_.rounds.model) <= LargestStepByChance(n))) {
      return;
    }
    for (std::size_t i = 0; i < n; ++i) {
      theta[i] += step[i];
      if (theta[i] < model.set.Lower(i) || theta[i] > model.set.Upper(i)) {
        return;
      }
    }
    model.set.layout().Scatter(model.set.ValuesFromTheta(theta), state_.scene);
    FixExposureGauge(model.set, views.fitted, exposure_, state_.scene);
    FixColorGauge(model.set, spec_, start_, state_.scene);
  }

  [[nodiscard]] std::vector<Candidate> StageCandidates(const StageSpec& stage,
                                                       const ParameterSet& set) const {
    std::vector<Candidate> candidates;
    // What rounds add up in a model needs no average of their steps.
    if (state_.rounds.model.Empty() && state_.RoundsOfLevel() > 1 &&
        SameShapes(state_.average.newer.scene, state_.scene)) {
      candidates.push_back({"averaged", AverageIterate(state_.average, set).scene});
    }
    candidates.push_back({"last", state_.scene});
    for (Candidate& candidate : candidates) {
      UnfoldNew(state_.stage_start, set.layout(), candidate.scene);
    }
    candidates.push_back({"start", state_.stage_start, true});
    if (state_.stage > 0 && state_.stage + 1 == static_cast<int>(spec_.stages.size())) {
      candidates.push_back({"start of the run", start_, true});
    }
    for (Candidate& candidate : candidates) {
      FixColorGauge(FreeSet(candidate.scene, stage), spec_, start_, candidate.scene);
    }
    return candidates;
  }

  /// Moves the state to the candidate that costs least. All are compared on a few samples, and on
  /// many those that the stage may have started better with: which of several good ends is kept
  /// matters little. Returns whether few told all that the stage may have started better with.
  bool KeepBest(const StageSpec& stage, const FitViews& views, StageReport& report) {
    std::vector<Candidate> open = StageCandidates(stage, MakeModel(state_.scene, stage, views).set);
    for (const int spp : {FitEvaluation::kFirstSpp, FitEvaluation::kMostSpp}) {
      std::vector<const renderer::Scene*> scenes;
      for (const Candidate& candidate : open) {
        scenes.push_back(&candidate.scene);
      }
      const CostComparison comparison = Compare(scenes, stage, views, spp);
      const std::vector<EvaluatedCost>& costs = comparison.costs;
      const auto best = static_cast<std::size_t>(
          std::min_element(costs.begin(),
                           costs.end(),
                           [](const auto& a, const auto& b) { return a.Total() < b.Total(); }) -
          costs.begin());
      // Both reported costs are of the last samples that the stage's start was in the running for.
      const auto start = std::ranges::find(open, std::string("start"), &Candidate::name);
      if (start != open.end()) {
        report.cost_before = costs[static_cast<std::size_t>(start - open.begin())].Total();
        for (std::size_t i = 0; i < open.size(); ++i) {
          open[i].cost = costs[i].Total();
        }
      }
      report.kept = open[best].name;
      report.cost_after = open[best].cost;
      state_.scene = open[best].scene;
      std::vector<Candidate> still_open;
      for (std::size_t i = 0; i < open.size(); ++i) {
        if (i == best || !comparison.IsSurelyWorse(i, best)) {
          still_open.push_back(std::move(open[i]));
        }
      }
      open = std::move(still_open);
      if (open.size() == 1 || std::ranges::none_of(open, &Candidate::is_start)) {
        return spp == FitEvaluation::kFirstSpp;
      }
    }
    return false;
  }

  [[nodiscard]] CostComparison Compare(const std::vector<const renderer::Scene*>& scenes,
                                       const StageSpec& stage,
                                       const FitViews& views,
                                       int spp) {
    std::vector<ComparedScene> compared;
    for (const renderer::Scene* scene : scenes) {
      compared.push_back(
          {evaluation_.MakeSource(*scene, {}, views), PriorCostOf(*scene, stage, views)});
    }
    return CompareCosts(
        compared, views, spec_.loss, evaluation_.Samples(state_.stage, spp), division_);
  }

  [[nodiscard]] double PriorCostOf(const renderer::Scene& scene,
                                   const StageSpec& stage,
                                   const FitViews& views) const {
    const Model model = MakeModel(scene, stage, views);
    return PriorCost(
        model.priors, model.set, model.set.ThetaFromValues(model.set.layout().Gather(scene)));
  }

  /// Of the reported pictures, in pixels.
  [[nodiscard]] double SmallerSide() const {
    return spec_.stages.back().image_scale * SmallestSide(observations_);
  }
  [[nodiscard]] int DraftSpp() const { return FitEvaluation::DraftSpp(SmallerSide()); }

  /// `remeasured`: stage whose end costs what the pictures say; null: what the report says.
  void Report(StageReport report, int spp, const StageSpec* remeasured) {
    observer_.OnScene(report.stage, state_.scene, state_.standard_errors);
    const ImageCosts fitted =
        evaluation_.Report(evaluation_.Samples(state_.stage, spp), observer_, state_.scene, report);
    if (!division_.IsFirst()) {
      return;
    }
    if (remeasured != nullptr) {
      const FitViews& views = evaluation_.ViewsAt(remeasured->image_scale);
      const double cost =
          (fitted.Total() + PriorCostOf(state_.scene, *remeasured, views)) / views.num_channels;
      // Their difference, of the same samples, has less noise than either.
      report.cost_before += cost - report.cost_after;
      report.cost_after = cost;
    }
    report.wall_s = WallSeconds();
    observer_.OnStage(report);
    result_.stages.push_back(std::move(report));
  }

  void SaveStageEnd() const {
    if (division_.IsFirst() && !controls_.checkpoint_folder.empty()) {
      WriteStageEnd(
          controls_.checkpoint_folder, {start_, spec_.unknowns}, state_.stage, state_.scene);
    }
  }

  void SaveCheckpoint() {
    if (division_.IsFirst()) {
      ++state_.sequence;
      state_.wall_s = WallSeconds();
      if (!controls_.checkpoint_folder.empty()) {
        WriteCheckpoint(controls_.checkpoint_folder, {start_, spec_.unknowns}, state_);
      }
    }
    ShareState();
  }

  /// Of the stage's rounds.
  void ReportDivision(const StageSpec& stage) {
    const DivisionTimes times = division_.TakeTimes();
    if (division_.IsAlone()) {
      return;
    }
    std::array<char, 200> text{};
    std::snprintf(text.data(),
                  text.size(),
                  "%d ranks rendered for %.3g processor seconds and sent %.3g MB, merged by the "
                  "first in %.3g, which waited %.3g s",
                  division_.NumRanks(),
                  times.making,
                  times.bytes / 1e6,
                  times.taking,
                  times.waiting);
    observer_.OnMessage("stage '" + stage.name + "': " + text.data());
  }

  /// Gives all ranks the state of the first, which alone takes steps.
  void ShareState() { ShareState(state_); }
  void ShareState(FitState& state) {
    if (division_.IsAlone()) {
      return;
    }
    const FitOrigin origin{start_, spec_.unknowns};
    const Bytes bytes = division_.Share(division_.IsFirst() ? EncodeState(origin, state) : Bytes());
    if (!division_.IsFirst()) {
      state = DecodeState(origin, bytes);
    }
  }

  const renderer::Scene& start_;
  const ObservationSet& observations_;
  const FitSpec& spec_;
  FitObserver& observer_;
  const FitControls& controls_;
  ExposureModel exposure_;
  ParameterSet all_;  ///< every unknown that is not held
  FreeGains free_gains_;
  Division division_;  ///< of views among ranks
  FitEvaluation evaluation_;
  FitState state_;
  FitResult result_;
  std::string failure_;          ///< what the solver said if the last round has no step
  double round_s_ = 0.0;         ///< of the last round
  double earlier_wall_s_ = 0.0;  ///< of sessions before this one
  renderer::Clock::time_point session_start_;
};

}  // namespace

FitResult RunFit(const renderer::Scene& start,
                 const ObservationSet& observations,
                 const FitSpec& spec,
                 FitObserver& observer,
                 const FitControls& controls) {
  Validate(start, observations, spec);
  renderer::ReturnFreedMemory();  // what photos and masks were read into
  if (controls.ranks == nullptr || controls.ranks->IsAlone()) {
    return FitDriver(start, observations, spec, observer, controls).Run();
  }
  try {
    FitResult result = FitDriver(start, observations, spec, observer, controls).Run();
    const bool is_early =
        result.status == FitStatus::kCancelled || result.status == FitStatus::kStageReached;
    if (controls.ranks->IsFirst() && is_early) {
      controls.ranks->Stop();
    }
    return result;
  } catch (...) {
    if (controls.ranks->IsFirst()) {
      controls.ranks->Stop();
    } else {
      controls.ranks->ReportException();
    }
    throw;
  }
}

}  // namespace pathfit::optim
