#include "optim/round/round_runner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "optim/problem/camera_guard.h"
#include "optim/problem/image_problem.h"
#include "optim/problem/motion_guard.h"
#include "optim/problem/vertex_guard.h"
#include "optim/round/color_gauge.h"
#include "optim/round/evaluation.h"
#include "optim/round/exposure_gauge.h"
#include "optim/round/recorded_errors.h"
#include "optim/round/round_policy.h"
#include "optim/solver/trust_region_solver.h"
#include "renderer/core/clock.h"
#include "renderer/core/process_memory.h"

namespace pathfit::optim {
namespace {

// Errors below this share of what a parameter has moved by or is (a factor, of logarithms), or of
// the error by photos and beliefs, are not worth more samples.
constexpr double kPrecision = 1e-3;
constexpr double kShareOfOthers = 0.5;
// Of what is left unexplained, by which beliefs are weighed: a change that matters.
constexpr double kOtherWeight = 1.25;
// Mean square of a step, in the errors by what the photos leave unexplained, that is not worth it.
constexpr double kNothingLeft = 0.05;
// A step pays that lowers the cost by this share, if the cost is not noise itself.
constexpr double kPayingStep = 0.03;
constexpr double kHidingNoise = 0.5;
constexpr double kSurelyMore = 10.0;  // standard deviations
constexpr double kNoDeviation = 1e-300;

using renderer::Clock;
using renderer::SecondsSince;

// Mean of diag(J^T J) over the vertex coordinates of the layout.
double MeanVertexDiagonal(const ParameterSet& set, const std::vector<double>& diagonal) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const renderer::ParameterGroup& group : set.layout().groups()) {
    if (group.kind == renderer::ParameterKind::kVertexPositions) {
      const auto first = static_cast<std::size_t>(group.first_scalar);
      const std::size_t size = 3 * static_cast<std::size_t>(group.num_blocks);
      for (std::size_t i = first; i < first + size; ++i) {
        sum += diagonal[i];
      }
      count += size;
    }
  }
  return count == 0 ? 0.0 : sum / static_cast<double>(count);
}

double LargestMagnitude(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) {
    largest = std::max(largest, std::abs(value));
  }
  return largest;
}

double Distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += (a[i] - b[i]) * (a[i] - b[i]);
  }
  return std::sqrt(sum);
}

void ReportFittedQuality(const std::vector<ViewQuality>& quality, RoundReport& report) {
  KnownMean psnr, iou;
  for (const ViewQuality& view : quality) {
    psnr.Add(view.psnr_linear);
    iou.Add(view.iou);
  }
  report.psnr_linear_fit = psnr.Value();
  report.iou_fit = iou.Value();
}

/// Of a photo in a round; the film stays where it is made.
struct HeldOutView {
  ViewQuality quality;
  ImageCosts costs;
  static void VisitParts(auto& view, const auto& visit) {
    visit(view.quality);
    visit(view.costs);
  }
};

/// Of all held-out photos, at the round's start.
ImageCosts MeasureHeldOut(const StageContext& context,
                          const ImageSource& source,
                          RoundReport& report) {
  KnownMean psnr, iou;
  ImageCosts costs;
  const int spp = std::min(report.samples.spp, kValidationSpp);
  // The same samples in all rounds, which then differ by the scene alone.
  const SampleHalves samples =
      MakeHalves(context.spec.seed, context.stage, 0, SampleUse::kValidation, {.spp = spp});
  context.division.ForEachThing<HeldOutView>(
      Division::Kind::kValidation,
      context.views.validation,
      [&](std::size_t i, const auto& give) {
        const int view = context.views.validation[i];
        const ViewLevel level = context.views.levels[static_cast<std::size_t>(view)].Unpack();
        const ReportedView reported = RenderForReport(
            source, context.views, view, level, context.spec.loss, samples, context.free_gains);
        give({reported.quality, reported.costs});
      },
      [&](std::size_t, const HeldOutView& view) {
        psnr.Add(view.quality.psnr_linear);
        iou.Add(view.quality.iou);
        costs.Add(view.costs);
      });
  report.psnr_linear_val = psnr.Value();
  report.iou_val = iou.Value();
  return costs;
}

SolveOutcome Solve(const StageContext& context,
                   const FitState& state,
                   ImageProblem& problem,
                   const std::vector<double>& theta,
                   const MotionGuard& motion,
                   RoundReport& report) {
  const std::vector<double> values = context.set.ValuesFromTheta(theta);
  const VertexGuard guard(state.scene, context.set, values);
  const CameraGuard cameras(state.scene, context.set, values);
  const double mu = ProximalWeight(state.damping,
                                   MeanVertexDiagonal(context.set, problem.sums().diagonal),
                                   report.noise_relative);
  const std::vector<PriorTerm> proximal =
      BuildProximalTerms(state.scene, context.spec.unknowns, context.set, values, mu);
  SolveOptions options;
  if (problem.UsesGram()) {
    options.linear_solver = LinearSolverKind::kGram;
  } else if (problem.UsesSparseGram()) {
    options.linear_solver = LinearSolverKind::kSparseGram;
  } else {
    options.linear_solver =
        SolverOfRows(context.spec.linear_solver, problem.size(), context.spec.max_memory_bytes);
  }
  options.radius =
      TrustRadius(problem.UsesGram() ? 0.0 : report.noise_relative, state.radius_factor);
  options.shared_radius_factor = TrustRadius(0.0, state.radius_factor) / options.radius;
  options.step_share = state.step_share;
  options.restrain = [&](std::vector<double>& trial) {
    context.set.DropTurnsAboutAxes(values, trial);
    return guard.Restrain(trial) && cameras.Restrain(trial) && motion.Admits(trial);
  };
  report.linear_solver = LinearSolverName(options.linear_solver);
  report.trust_radius = options.radius;
  return SolveRound(problem, context.priors, proximal, theta, options);
}

/// The photos' cost, which is a difference of two sums of `num_channels` squares, in standard
/// deviations of that difference.
double CostOverNoise(const ImageCosts& costs, double num_channels) {
  const double deviation =
      2.0 * std::sqrt(costs.signal_squared * costs.noise_squared / std::max(1.0, num_channels));
  return (costs.signal_squared - costs.noise_squared) / std::max(kNoDeviation, deviation);
}

double Norm(const double* values, int size) {
  return std::sqrt(std::inner_product(values, values + size, values, 0.0));
}

/// Whether the errors by the renderings' noise are small beside all that they can be compared with.
bool ArePrecise(const StandardErrors& errors,
                const ParameterSet& set,
                const std::vector<double>& theta,
                const std::vector<double>& start) {
  for (std::int32_t block = 0; block < static_cast<std::int32_t>(set.NumBlocks()); ++block) {
    const std::size_t offset = set.BlockOffset(block);
    const int size = set.BlockSize(block);
    std::vector<double> moved(theta.begin() + static_cast<std::ptrdiff_t>(offset),
                              theta.begin() + static_cast<std::ptrdiff_t>(offset) + size);
    double scale = set.IsLog(offset) ? 1.0 : Norm(moved.data(), size);
    for (int c = 0; c < size; ++c) {
      moved[static_cast<std::size_t>(c)] -= start[offset + static_cast<std::size_t>(c)];
    }
    scale = std::max(scale, Norm(moved.data(), size));
    const double others = std::hypot(Norm(errors.of_photos.data() + offset, size),
                                     Norm(errors.of_beliefs.data() + offset, size));
    if (Norm(errors.of_rendering.data() + offset, size) >
        std::max(kPrecision * scale, kShareOfOthers * others)) {
      return false;
    }
  }
  return true;
}

/// Whether all that is left to the minimum of the model is small beside what the photos cannot
/// tell: a step of one standard error in every direction lowers the cost by its mean over the
/// photos' numbers, for each unknown. Not while the cost is mostly noise.
bool IsNothingLeft(const StageContext& context,
                   const ImageCosts& costs,
                   const QuadraticModel& model,
                   const std::vector<double>& theta,
                   const std::vector<double>& prior_hessian) {
  if (RelativeNoise(costs) >= kHidingNoise) {
    return false;
  }
  const double decrease = FindMinimum(model,
                                      theta,
                                      prior_hessian,
                                      PriorGradient(context.priors, context.set, theta),
                                      context.set.InsideBounds(theta))
                              .decrease;
  return decrease < kNothingLeft * costs.Total() * static_cast<double>(model.NumScalars()) /
                        context.views.num_channels;
}

/// Adds to the priors' matrix, for errors, that the mean base colour is as a rule says, where one
/// holds: photos tell nothing along the common scale, so that any weight keeps errors on the rule.
void AddRule(const StageContext& context,
             const QuadraticModel& model,
             const renderer::Scene& scene,
             std::vector<double>& hessian) {
  const std::size_t n = model.NumScalars();
  for (const std::vector<double>& slopes : SlopesOfRule(context.set, context.spec, scene)) {
    double curvature = 0.0, square = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      if (slopes[i] != 0.0) curvature += model.square[i * (n + 1)] / model.weight;
      square += slopes[i] * slopes[i];
    }
    if (!(square > 0.0)) continue;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        hessian[i * n + j] += curvature / square * slopes[i] * slopes[j];
      }
    }
  }
}

/// What the model says of the step just taken and of the point it leads to. `costs`: of the round's
/// start. Returns whether the step's own error explains it.
bool Judge(const StageContext& context,
           const std::vector<double>& before,
           const std::vector<double>& step,
           const SolveOutcome& outcome,
           const ImageCosts& costs,
           const QuadraticModel& model,
           double motion,
           FitState& state) {
  const bool explained = SignificanceOfStep(step, model) <= LargestStepByChance(model.NumScalars());
  std::vector<double> prior_hessian = PriorHessian(context.priors, context.set, outcome.theta);
  AddRule(context, model, state.scene, prior_hessian);
  std::vector<double> ranges(context.set.NumScalars());
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    ranges[i] = context.set.Upper(i) - context.set.Lower(i);
  }
  const StandardErrors errors = EstimateErrors(
      model, prior_hessian, BeliefCovariance(context.priors, context.set, outcome.theta), ranges);
  std::vector<double> start = before;
  if (SameShapes(state.stage_start, state.scene)) {
    start = context.set.ThetaFromValues(context.set.layout().Gather(state.stage_start));
  }
  const bool is_done =
      !errors.is_hidden && IsNothingLeft(context, costs, model, outcome.theta, prior_hessian);
  // The first steps of a noisy round are within their error, however far they lead; so is what is
  // left of a step that was cut as its end cannot be rendered.
  const bool is_within =
      outcome.accepted && ((explained && outcome.refused == 0) || is_done) && motion < kStillPixels;
  state.within_error = is_within ? state.within_error + 1 : 0;
  state.precise =
      is_done || (!errors.is_hidden && ArePrecise(errors, context.set, outcome.theta, start));
  RecordErrors(context.set, outcome.theta, errors, state.standard_errors);
  return explained;
}

/// Which round it is, and its samples.
RoundReport BeginReport(const StageContext& context, const FitState& state) {
  const StageSpec& stage = context.spec.stages[static_cast<std::size_t>(context.stage)];
  RoundReport report;
  report.step = state.step + 1;
  report.stage = stage.name;
  report.stage_index = context.stage;
  report.num_stages = static_cast<int>(context.spec.stages.size());
  report.round = state.round + 1;
  report.max_rounds = stage.max_rounds;
  report.image_scale = context.image_scale;
  report.samples = BudgetOfRound(context, state);
  return report;
}

/// `moves`: whether an unknown moves geometry.
ImageProblemOptions OptionsOfRound(const StageContext& context,
                                   const RoundReport& report,
                                   bool moves,
                                   const FitState& state) {
  const StageSpec& stage = context.spec.stages[static_cast<std::size_t>(context.stage)];
  ImageProblemOptions options;
  options.loss = context.spec.loss;
  options.linear_solver = context.spec.linear_solver;
  options.max_memory_bytes = context.spec.max_memory_bytes;
  options.samples =
      MakeHalves(context.spec.seed, context.stage, report.round, SampleUse::kFit, report.samples);
  // A model of other unknowns (shapes have changed) says nothing about these.
  const QuadraticModel& earlier = state.rounds.model;
  options.earlier = earlier.NumScalars() == context.set.NumScalars() && !earlier.Empty()
                        ? &state.rounds
                        : nullptr;
  options.weight = report.samples.spp;
  // Where nothing moves there are no boundaries to divide samples among.
  if (!stage.samples.HasAll() && moves) {
    options.num_measured = std::min(kMeasuredViews, context.views.fitted.size());
    options.first_measured = static_cast<std::size_t>(report.round);
  }
  options.division = &context.division;
  return options;
}

/// Of the round's start.
void ReportCosts(const StageContext& context,
                 const ImageProblem& problem,
                 double priors,
                 RoundReport& report) {
  const double unit = 1.0 / context.views.num_channels;
  const ImageCosts& costs = problem.costs();
  report.cost_image = costs.colors * unit;
  report.cost_silhouette = costs.coverage * unit;
  report.cost_priors = priors * unit;
  report.cost_total = report.cost_image + report.cost_silhouette + report.cost_priors;
  report.noise_relative = RelativeNoise(costs);
  report.gradient_max = LargestMagnitude(problem.sums().gradient) * unit;
  ReportFittedQuality(problem.quality(), report);
}

/// Moves the scene to where an accepted step leads, whose photos cost `after`. `values` is memory
/// to work in.
void TakeStep(const StageContext& context,
              const std::vector<double>& theta,
              const SolveOutcome& outcome,
              const MotionGuard& motion,
              double after,
              std::vector<double>& values,
              RoundReport& report,
              FitState& state) {
  const double unit = 1.0 / context.views.num_channels;
  const double cost = (after + PriorCost(context.priors, context.set, outcome.theta)) * unit;
  report.cost_change_rel =
      (cost - report.cost_total) / std::max(std::abs(report.cost_total), 1e-300);
  report.step_norm = Distance(theta, outcome.theta);
  values = context.set.ValuesFromTheta(outcome.theta);
  report.motion = motion.LargestMotion(values);
  renderer::Scene moved = state.scene;
  context.set.layout().Scatter(values, moved);
  FixExposureGauge(context.set, context.views.fitted, context.exposure, moved);
  FixColorGauge(context.set, context.spec, context.start, moved);
  state.scene = std::move(moved);
}

/// Counts the rounds that change nothing any more, and those that need more samples. `before`:
/// costs of the round's start; `explained`: Judge.
void CountSigns(const StageContext& context,
                const ImageProblem& problem,
                const ImageCosts& before,
                bool moves,
                bool explained,
                const RoundReport& report,
                FitState& state) {
  const StageSpec& stage = context.spec.stages[static_cast<std::size_t>(context.stage)];
  bool needs_more = FitsNoise(state, report.cost_total);  // by the costs before
  state.costs.push_back(report.cost_total);
  // What the scene cannot explain leaves a cost at which badly determined unknowns wander on,
  // whatever the model promises of each step. A step of many unknowns also fits the noise of its
  // own samples: if even their cost hardly falls, it leads nowhere.
  const bool may_end = stage.stop_relative_cost > 0.0 && report.accepted;
  bool is_flat = may_end && -report.cost_change_rel < stage.stop_relative_cost;
  bool tells = true;
  int signs = kSignsOfRound;
  if (problem.UsesGram()) {
    const double over_noise = CostOverNoise(before, context.views.num_channels);
    is_flat |= may_end && NoLongerFalls(state.costs, stage.stop_relative_cost, over_noise);
    tells = over_noise > kSurelyMore;
    // Where the rest of the photos is mostly noise, so is what a step did to it.
    if (report.noise_relative >= kHidingNoise) signs = 1;
  }
  is_flat &= tells;
  if (tells) state.flat = is_flat && !(moves && problem.UsesGram()) ? state.flat + signs : 0;
  // Small steps that still pay lead on: weakly determined directions move little that is seen.
  const bool pays = report.cost_change_rel < -kPayingStep && report.noise_relative < kHidingNoise;
  // Steps of many unknowns are short while noise limits them, which says nothing.
  const bool is_limited = !problem.UsesGram() && report.noise_relative >= kHidingNoise;
  // What moves nothing that is seen, such as a light, is judged by its error and by the cost.
  const bool is_still = report.accepted && report.motion < kStillPixels && !pays && !is_limited &&
                        (report.motion > 0.0 || state.within_error > 0 || is_flat);
  state.still = is_still ? state.still + 1 : 0;
  // The errors of few unknowns fall with the samples of all rounds, until they are precise; while
  // something is on its way, only a step that is noise needs more. Each step of many has its own.
  if (!problem.UsesGram()) {
    needs_more |= !report.accepted;
  } else if (moves) {
    needs_more |= explained;
  } else {
    needs_more = !state.precise;
  }
  state.growths += needs_more ? 1 : 0;
  state.promised_cost = report.cost_total * (1.0 + report.cost_change_rel);
}

/// What the round tells the next ones of samples and of the model. `before`: costs of its start.
/// Returns what Judge says.
bool Learn(const StageContext& context,
           const std::vector<double>& theta,
           const SolveOutcome& outcome,
           const ImageCosts& before,
           const RoundReport& report,
           ImageProblem& problem,
           FitState& state) {
  AdaptStepControl(outcome, problem.UsesGram(), state);
  // Many unknowns are limited by damping, not by the noise of J: time buys nothing there.
  state.split =
      problem.split_meter().Improve(SplitOfRound(report.samples, state.split),
                                    problem.UsesGram() ? std::nullopt : std::optional(kStartSplit));
  if (!problem.UsesGram()) {
    RecordUnseen(context.set, problem.sums().diagonal, state.standard_errors);
    return false;
  }
  std::vector<double> step = outcome.theta;
  for (std::size_t i = 0; i < step.size(); ++i) {
    step[i] -= theta[i];
  }
  state.rounds = problem.TakeRounds();
  const bool explained =
      Judge(context, theta, step, outcome, before, state.rounds.model, report.motion, state);
  state.rounds.Forget(step);
  return explained;
}

/// Priors are made anew where it matters.
void WeighBeliefs(double unexplained, FitState& state) {
  if (unexplained > kOtherWeight * state.unexplained ||
      kOtherWeight * unexplained < state.unexplained) {
    state.unexplained = unexplained;
  }
}

}  // namespace

renderer::SampleBudget BudgetOfRound(const StageContext& context, const FitState& state) {
  const StageSpec& stage = context.spec.stages[static_cast<std::size_t>(context.stage)];
  return BudgetOfRound(stage.samples,
                       SamplesOfRound(stage, state.growths, context.sample_factor),
                       state.split,
                       context.spec.estimators);
}

RoundReport RunRound(const StageContext& context, ImageSource& source, FitState& state) {
  RoundReport report = BeginReport(context, state);
  const bool moves = context.set.layout().AnyKind(renderer::MovesGeometry);
  const std::vector<double> theta =
      context.set.ThetaFromValues(context.set.layout().Gather(state.scene));
  const auto start = Clock::now();
  ImageProblem problem(
      source, context.views, context.set, OptionsOfRound(context, report, moves, state));
  problem.Linearize(context.set.ValuesFromTheta(theta));
  report.jacobian_s = SecondsSince(start);
  const auto validation_start = Clock::now();
  const ImageCosts held_out = MeasureHeldOut(context, source, report);
  report.render_s = SecondsSince(validation_start);
  if (!context.division.IsFirst()) {
    problem.FollowTrials();
    return report;
  }
  const ImageCosts before = problem.costs();
  ReportCosts(context, problem, PriorCost(context.priors, context.set, theta), report);

  const MotionGuard motion(
      state.scene, context.set, context.views, context.set.ValuesFromTheta(theta));
  const SolveOutcome outcome = Solve(context, state, problem, theta, motion, report);
  problem.EndTrials();
  report.render_s += outcome.render_s;
  report.linear_s = outcome.linear_s;
  report.accepted = outcome.accepted;
  state.accepted += outcome.accepted ? 1 : 0;
  report.solver_failure = outcome.failure;
  report.jacobian_mb = JacobianBytes(problem.size(), problem.UsesGram()) / 1e6;
  std::vector<double> values;
  if (outcome.accepted) {
    TakeStep(context, theta, outcome, motion, problem.costs().Total(), values, report, state);
  }
  context.set.layout().Gather(state.scene, values);
  source.SetValues(values);
  const bool explained = Learn(context, theta, outcome, before, report, problem, state);
  CountSigns(context, problem, before, moves, explained, report, state);
  // Rounds of few unknowns average their noise, those of many have each their own.
  WeighBeliefs(UnexplainedResidual(before, !problem.UsesGram()), state);
  if (held_out.Total() > kSurelyMore * std::sqrt(held_out.variance)) {
    state.held_out_costs.push_back(held_out.Total());
  } else {
    state.held_out_costs.clear();
  }
  if (!problem.UsesGram()) {
    AddIterate(
        state.average, state.RoundsOfLevel() + 1, report.samples.spp, context.set, state.scene);
  }
  state.round = report.round;
  state.step = report.step;
  report.peak_rss_mb = renderer::ProcessMemory("VmHWM:") / 1e6;
  return report;
}

}  // namespace pathfit::optim
