#include "optim/round/fit_driver.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

#include "optim/checkpoint/checkpoint.h"
#include "optim/round/fit_fingerprint.h"
#include "optim/round/iterate_average.h"
#include "optim/round/seed_policy.h"
#include "optim/round/step_control.h"
#include "optim/round/stopping_rule.h"
#include "renderer/core/error.h"
#include "renderer/derivative/derivative_limits.h"

namespace pathfit::optim {
namespace {

constexpr int kMinEvaluationSpp = 64;

std::vector<int> Range(std::size_t count) {
  std::vector<int> indices(count);
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

ExposureModel MakeExposureModel(const renderer::Scene& scene, const FitSpec& spec) {
  ExposureModel exposure{{}, spec.exposure_sigma_ev, spec.exposure_max_ev};
  for (const renderer::Camera& sensor : scene.sensors) {
    exposure.start_gains.push_back(sensor.gain);
  }
  return exposure;
}

void Average(StageReport& report) {
  double fit = 0.0, val = 0.0;
  for (const ViewReport& view : report.views) {
    (view.validation ? val : fit) += 1.0;
  }
  const double none = std::numeric_limits<double>::quiet_NaN();
  report.psnr_srgb_fit = report.psnr_linear_fit = report.iou_fit = fit > 0.0 ? 0.0 : none;
  report.psnr_srgb_val = report.psnr_linear_val = report.iou_val = val > 0.0 ? 0.0 : none;
  for (const ViewReport& view : report.views) {
    const double count = view.validation ? val : fit;
    (view.validation ? report.psnr_srgb_val : report.psnr_srgb_fit) += view.psnr_srgb / count;
    (view.validation ? report.psnr_linear_val : report.psnr_linear_fit) += view.psnr_linear / count;
    (view.validation ? report.iou_val : report.iou_fit) += view.iou / count;
  }
}

}  // namespace

struct FitDriver::Stage {
  const StageSpec& spec;
  const FitViews& views;
  renderer::Scene start;
  ParameterSet set;
  std::vector<PriorTerm> priors;
  std::unique_ptr<SceneImageSource> source;
};

FitDriver::FitDriver(renderer::Scene start,
                     const ObservationSet& observations,
                     const FitSpec& spec,
                     FitObserver& observer,
                     const FitControls& controls)
    : start_(std::move(start)),
      observations_(observations),
      spec_(spec),
      observer_(observer),
      controls_(controls),
      exposure_(MakeExposureModel(start_, spec)),
      all_(start_,
           spec.unknowns,
           Range(spec.unknowns.size()),
           Range(start_.sensors.size()),
           exposure_),
      scene_(start_),
      session_start_(std::chrono::steady_clock::now()) {
  for (const renderer::ParameterGroup& group : all_.layout().groups()) {
    fits_exposure_ = fits_exposure_ || group.kind == renderer::ParameterKind::kExposure;
  }
}

FitDriver::~FitDriver() = default;

double FitDriver::WallSeconds() const {
  const std::chrono::duration<double> session = std::chrono::steady_clock::now() - session_start_;
  return session_start_wall_s_ + session.count();
}

void FitDriver::Validate() const {
  if (start_.sensors.size() != observations_.views.size()) {
    throw renderer::SceneError("the scene has " + std::to_string(start_.sensors.size()) +
                               " sensors for " + std::to_string(observations_.views.size()) +
                               " views; they must correspond one to one");
  }
  const bool any_fitted = std::any_of(observations_.views.begin(),
                                      observations_.views.end(),
                                      [](const View& view) { return !view.validation; });
  if (!any_fitted) {
    throw renderer::SceneError("every view is held out for validation: there is nothing to fit to");
  }
  if (spec_.stages.empty()) {
    throw renderer::SceneError("the fit has no stages");
  }
  for (const UnknownSpec& unknown : spec_.unknowns) {
    const bool of_one_view =
        renderer::ObjectListOf(unknown.kind) == renderer::ObjectList::kSensors &&
        unknown.object >= 0 && !unknown.hold;
    if (of_one_view && observations_.views[static_cast<std::size_t>(unknown.object)].validation) {
      throw renderer::SceneError("'" + unknown.name +
                                 "' cannot be fitted: its view is held out for validation");
    }
  }
}

const FitViews& FitDriver::ViewsAt(double scale) {
  if (!views_ || views_scale_ != scale) {
    views_ = std::make_unique<FitViews>(MakeFitViews(observations_, scale));
    views_scale_ = scale;
  }
  return *views_;
}

std::unique_ptr<SceneImageSource> FitDriver::MakeSource(const renderer::Scene& scene,
                                                        const renderer::ParameterLayout& layout,
                                                        const FitViews& views) const {
  std::vector<renderer::Camera> cameras;
  for (const ViewLevel& level : views.levels) {
    cameras.push_back(level.camera);
  }
  return std::make_unique<SceneImageSource>(
      scene, layout, std::move(cameras), spec_.estimators, controls_.cancel);
}

FitResult FitDriver::Run() {
  Validate();
  state_.fingerprint = FitFingerprint(spec_, all_, observations_);
  if (controls_.resume) {
    Resume();
  }
  const bool any_held_out = std::any_of(observations_.views.begin(),
                                        observations_.views.end(),
                                        [](const View& view) { return view.validation; });
  if (fits_exposure_ && any_held_out) {
    observer_.OnMessage(
        "assumption: the gain of each held-out view is estimated from its own photo, one number "
        "per view; nothing else of it enters the fit");
  }
  for (const std::string& limit : renderer::DerivativeLimits(start_, all_.layout())) {
    observer_.OnMessage("not in the derivative: " + limit);
  }
  try {
    if (!controls_.resume) {
      ReportStart();
      state_.current = all_.layout().Gather(scene_);
      state_.stage_start = state_.current;
      state_.damping = kStartDamping;
    }
    RunStages();
  } catch (const renderer::Cancelled&) {
    result_.status = FitStatus::kCancelled;
  }
  result_.scene = scene_;
  result_.rounds = state_.step;
  result_.wall_s = WallSeconds();
  return std::move(result_);
}

void FitDriver::Resume() {
  const FitState& state = *controls_.resume;
  const std::size_t count = all_.NumScalars();
  if (state.fingerprint != state_.fingerprint || state.current.size() != count ||
      state.stage_start.size() != count) {
    throw renderer::IoError(
        "the checkpoint belongs to another experiment: views, unknowns, stages or seed differ "
        "(checkpoint: " +
        state.fingerprint + "; now: " + state_.fingerprint + ")");
  }
  state_ = state;
  session_start_wall_s_ = state.wall_s;
  all_.layout().Scatter(state.current, scene_);
}

void FitDriver::RunStages() {
  while (state_.stage < static_cast<int>(spec_.stages.size())) {
    StartStage();
    if (stage_->set.NumScalars() == 0) {
      observer_.OnMessage("stage '" + stage_->spec.name + "' frees nothing and is skipped");
    }
    const bool in_time = stage_->set.NumScalars() == 0 || RunRounds();
    FinishStage(in_time ? StopReason(stage_->spec, state_) : "time limit");
    if (!in_time) {
      result_.status = FitStatus::kTimeLimit;
      return;
    }
    ++state_.stage;
    state_.round = 0;
    state_.radius_factor = 1.0;
    state_.damping = kStartDamping;
    state_.rejected_in_row = 0;
    state_.costs.clear();
    state_.average = {};
    state_.current = all_.layout().Gather(scene_);
    state_.stage_start = state_.current;
    SaveCheckpoint();
  }
}

void FitDriver::ReportStart() {
  StageReport report;
  report.stage = "start";
  const FitViews& views = ViewsAt(spec_.stages.back().image_scale);
  const SampleHalves samples =
      MakeHalves(spec_.seed,
                 0,
                 0,
                 SampleUse::kEvaluation,
                 {.spp = std::max(kMinEvaluationSpp, spec_.stages.back().max_spp)});
  report.kept = "start";
  ReportStage(std::move(report), views, samples);
}

void FitDriver::StartStage() {
  const StageSpec& spec = spec_.stages[static_cast<std::size_t>(state_.stage)];
  stage_.reset();
  const FitViews& views = ViewsAt(spec.image_scale);
  renderer::Scene start = start_;
  all_.layout().Scatter(state_.stage_start, start);
  ParameterSet set(start, spec_.unknowns, spec.free, views.fitted, exposure_);
  std::vector<PriorTerm> priors =
      BuildPriorTerms(start_, start, spec_.unknowns, set, exposure_, views.num_channels);
  auto source = MakeSource(scene_, set.layout(), views);
  stage_ = std::make_unique<Stage>(
      Stage{spec, views, std::move(start), std::move(set), std::move(priors), std::move(source)});
}

bool FitDriver::RunRounds() {
  const StageContext context{
      spec_, state_.stage, stage_->views, stage_->set, exposure_, stage_->priors, fits_exposure_};
  double round_s = 0.0;
  while (StopReason(stage_->spec, state_).empty()) {
    if (controls_.cancel != nullptr && controls_.cancel->load()) {
      throw renderer::Cancelled();
    }
    const double before = WallSeconds();
    if (spec_.time_limit_s > 0.0 && before - session_start_wall_s_ + round_s > spec_.time_limit_s) {
      return false;
    }
    RoundReport report = RunRound(context, *stage_->source, scene_, state_);
    state_.current = all_.layout().Gather(scene_);
    report.wall_s = WallSeconds();
    round_s = report.wall_s - before;
    // First the report: a resumed run drops rounds reported after its checkpoint, but cannot bring
    // back missing ones.
    observer_.OnRound(report);
    SaveCheckpoint();
  }
  return true;
}

SampleHalves FitDriver::EvaluationSamples() const {
  // One set per stage, apart from every round's; edges play no part in images.
  return MakeHalves(spec_.seed,
                    state_.stage,
                    0,
                    SampleUse::kEvaluation,
                    {.spp = std::max(kMinEvaluationSpp, stage_->spec.max_spp)});
}

std::vector<FitDriver::Candidate> FitDriver::StageCandidates() const {
  std::vector<Candidate> candidates;
  if (state_.round > 1) {
    Candidate averaged{"averaged", scene_};
    const std::vector<double> theta = AverageIterate(state_.average);
    stage_->set.layout().Scatter(stage_->set.ValuesFromTheta(theta), averaged.scene);
    candidates.push_back(std::move(averaged));
  }
  candidates.push_back({"last", scene_});
  candidates.push_back({"start", stage_->start});
  if (state_.stage > 0 && state_.stage + 1 == static_cast<int>(spec_.stages.size())) {
    candidates.push_back({"start of the run", start_});
  }
  return candidates;
}

void FitDriver::FinishStage(const std::string& stop_reason) {
  const SampleHalves samples = EvaluationSamples();
  std::vector<Candidate> candidates = StageCandidates();
  StageReport report;
  std::size_t best = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const auto& layout = stage_->set.layout();
    const auto source = MakeSource(candidates[i].scene, layout, stage_->views);
    const std::vector<double> theta =
        stage_->set.ThetaFromValues(layout.Gather(candidates[i].scene));
    const double cost = EvaluateCost(*source,
                                     stage_->views,
                                     spec_.loss,
                                     samples,
                                     PriorCost(stage_->priors, stage_->set, theta))
                            .Total();
    if (candidates[i].name == "start") {
      report.cost_before = cost;
    }
    if (i == 0 || cost < report.cost_after) {
      best = i;
      report.cost_after = cost;
    }
  }
  scene_ = std::move(candidates[best].scene);
  report.stage = stage_->spec.name;
  report.rounds = state_.round;
  report.kept = candidates[best].name;
  report.stop_reason = stop_reason;
  // Reports compare over stages only at one resolution: that of the last stage.
  const double scale = spec_.stages.back().image_scale;
  if (scale == views_scale_) {
    ReportStage(std::move(report), stage_->views, samples);
  } else {
    ReportStage(std::move(report), MakeFitViews(observations_, scale), samples);
  }
}

void FitDriver::ReportStage(StageReport report,
                            const FitViews& views,
                            const SampleHalves& samples) {
  const auto source = MakeSource(scene_, all_.layout(), views);
  std::vector<renderer::Film> images;
  std::vector<renderer::Image> photos;
  for (std::size_t v = 0; v < views.levels.size(); ++v) {
    const View& view = observations_.views[v];
    ReportedView reported = RenderForReport(
        *source, views, static_cast<int>(v), samples, view.validation && fits_exposure_);
    renderer::Camera& sensor = scene_.sensors[v];
    const double limit = std::exp2(exposure_.max_ev);
    sensor.gain = std::clamp(sensor.gain * reported.gain_factor,
                             exposure_.start_gains[v] / limit,
                             exposure_.start_gains[v] * limit);
    report.views.push_back({view.name,
                            view.validation,
                            reported.quality.psnr_linear,
                            reported.quality.psnr_srgb,
                            reported.quality.iou,
                            sensor.gain});
    images.push_back(std::move(reported.film));
    photos.push_back(views.levels[v].photo);
  }
  Average(report);
  report.wall_s = WallSeconds();
  observer_.OnStage(report, images, photos);
  result_.stages.push_back(std::move(report));
}

void FitDriver::SaveCheckpoint() {
  ++state_.sequence;
  state_.wall_s = WallSeconds();
  if (!controls_.checkpoint_folder.empty()) {
    WriteCheckpoint(controls_.checkpoint_folder, state_);
  }
}

}  // namespace pathfit::optim
