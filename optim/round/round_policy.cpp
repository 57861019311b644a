#include "optim/round/round_policy.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>

#include "renderer/sampler/counter_rng.h"

namespace pathfit::optim {
namespace {

renderer::RandomDomain DomainOf(SampleUse use) {
  switch (use) {
    case SampleUse::kValidation:
      return renderer::RandomDomain::kValidationSeed;
    case SampleUse::kEvaluation:
      return renderer::RandomDomain::kEvaluationSeed;
    default:
      return renderer::RandomDomain::kFitSeed;
  }
}

std::uint64_t MakeSeed(
    std::uint64_t seed, int stage, int round, SampleUse use, std::uint64_t half) {
  renderer::CounterRng rng(seed,
                           DomainOf(use),
                           static_cast<std::uint64_t>(stage),
                           static_cast<std::uint64_t>(round),
                           half);
  return rng.NextInteger();
}

constexpr double kMinRadius = 1e-4;
constexpr double kMaxRadius = 1e4;
constexpr double kMinDamping = 1e-6;
constexpr double kMaxDamping = 1e2;
constexpr double kGoodStep = 0.75;  // actual over predicted decrease
constexpr double kPoorStep = 0.25;
// Pixels whose samples together tell few unknowns enough for a round. Where there are more, each
// has fewer samples.
constexpr double kEnoughPixels = 5e4;
// What a coarse level gains more slowly is faster gained by the next one.
constexpr double kFallOfCoarseLevels = 0.1;
// More noise fitted than this share of what a step gains is worth more samples, which widen the
// trust region, too.
constexpr double kFittedShare = 0.1;
constexpr double kWidening = 4.0;  // of a kept radius after a good step

int FirstSamples(const StageSpec& stage) {
  return stage.samples.spp.value_or(std::min(StageBudget::kUsualSpp, stage.max_spp));
}

double MeanOf(const std::vector<double>& costs, std::size_t end) {
  double sum = 0.0;
  for (std::size_t i = end - kStopWindow; i < end; ++i) {
    sum += costs[i] / kStopWindow;
  }
  return sum;
}

/// Per pixel, had they no limit.
double GrownSamples(const StageSpec& stage, int growths) {
  return FirstSamples(stage) * std::pow(std::max(1.0, stage.spp_growth), growths);
}

/// Whether samples that grow have been as many as there may be for so many rounds of the level that
/// wanted more.
bool RunsShortOfSamples(const StageSpec& stage, const FitState& state) {
  const int before = std::min(state.RoundsOfLevel(), state.growths) - kRoundsShortOfSamples;
  return FirstSamples(stage) < stage.max_spp && GrownSamples(stage, before) >= stage.max_spp;
}

/// Theta of the mean of two scenes of the same shapes; the rest of `b`.
WeightedScene Mean(const WeightedScene& a, const WeightedScene& b, const ParameterSet& set) {
  const renderer::ParameterLayout& layout = set.layout();
  std::vector<double> values = layout.Gather(a.scene);
  std::vector<double> theta = set.ThetaFromValues(values);
  layout.Gather(b.scene, values);
  const std::vector<double> other = set.ThetaFromValues(values);
  const double weight = a.weight + b.weight;
  for (std::size_t i = 0; i < theta.size(); ++i) {
    theta[i] += b.weight / weight * (other[i] - theta[i]);
  }
  WeightedScene mean{weight, b.scene};
  layout.Scatter(set.ValuesFromTheta(theta), mean.scene);
  return mean;
}

}  // namespace

std::vector<double> ScalesOfStage(const StageSpec& stage, StageKind kind, int smallest_side) {
  const bool begins_small = kind.moves || kind.makes_texture;
  const int least = kind.few && begins_small ? kSmallestSide : kSmallestSideOfShapes;
  std::vector<double> scales{stage.image_scale};
  while (stage.coarse_to_fine && (begins_small || kind.few) &&
         static_cast<int>(scales.size()) < stage.max_rounds / kRoundsWithinError &&
         0.5 * scales.back() * smallest_side >= least) {
    scales.push_back(0.5 * scales.back());
  }
  if (!begins_small && scales.size() > 1) {
    if (kind.prepares) return {scales.back()};
    return {scales.back(), scales.front()};
  }
  std::reverse(scales.begin(), scales.end());
  return scales;
}

int NumLevels(const StageSpec& stage, const std::vector<double>& scales) {
  return static_cast<int>(scales.size()) + (scales.back() < stage.image_scale ? 1 : 0);
}

int SmallestSide(const ObservationSet& observations) {
  int smallest = std::numeric_limits<int>::max();
  for (const View& view : observations.views) {
    smallest = std::min({smallest, view.photo.width(), view.photo.height()});
  }
  return smallest;
}

int LevelShare(const StageSpec& stage, int num_levels) {
  return stage.max_rounds / (num_levels + 1) + 1;
}

double SampleFactor(const StageSpec& stage, double scale, double pixels, StageKind kind) {
  const double ratio = stage.image_scale / scale;
  if (!kind.few) {
    return ratio;
  }
  const double factor = kind.moves ? ratio * ratio : 1.0;
  return stage.samples.spp ? factor : std::min(factor, kEnoughPixels / std::max(1.0, pixels));
}

bool FitsNoise(const FitState& state, double cost) {
  if (state.costs.empty()) {
    return false;
  }
  // What a step fits of its samples' noise lowers their cost by as much as it raises that of
  // others.
  const double fitted = 0.5 * (cost - state.promised_cost);
  return fitted > kFittedShare * (state.costs.back() - cost);
}

int SamplesOfRound(const StageSpec& stage, int growths, double factor) {
  const int first = FirstSamples(stage);
  const double limited = factor * std::min(GrownSamples(stage, growths),
                                           static_cast<double>(std::max(first, stage.max_spp)));
  return std::max(2, 2 * static_cast<int>(std::lround(0.5 * limited)));
}

renderer::SampleBudget BudgetOfRound(const StageBudget& stage,
                                     int spp,
                                     const renderer::SampleBudget& split,
                                     const renderer::EstimatorOptions& estimators) {
  const auto budget =
      [&](renderer::DerivativeTerm term, const std::optional<double>& given, double found) {
        const double per_sample = given ? *given / std::max(1, stage.Spp()) : found;
        return estimators.Has(term) ? spp * per_sample : 0.0;
      };
  using enum renderer::DerivativeTerm;
  return {spp,
          budget(kPrimary, stage.sppe, split.sppe),
          budget(kDirect, stage.spp_direct, split.spp_direct),
          budget(kIndirect, stage.spp_indirect, split.spp_indirect),
          budget(kPixel, stage.spp_pixel, split.spp_pixel)};
}

renderer::SampleBudget SplitOfRound(const renderer::SampleBudget& round,
                                    const renderer::SampleBudget& split) {
  renderer::SampleBudget next = split;
  next.spp = 1;
  for (const auto budget : renderer::kBoundaryBudgets) {
    if (round.*budget > 0.0) {
      next.*budget = round.*budget / round.spp;
    }
  }
  return next;
}

SampleHalves MakeHalves(
    std::uint64_t seed, int stage, int round, SampleUse use, const renderer::SampleBudget& both) {
  const renderer::SampleBudget half = both.Scaled(0.5);
  return {{half, MakeSeed(seed, stage, round, use, 0)},
          {half, MakeSeed(seed, stage, round, use, 1)}};
}

double RelativeNoise(const ImageCosts& costs) {
  return costs.signal_squared > 0.0 ? std::sqrt(costs.noise_squared / costs.signal_squared) : 0.0;
}

double TrustRadius(double relative_noise, double radius_factor) {
  const double variance = std::max(relative_noise * relative_noise, 1e-12);
  return std::clamp(std::min(kMaxRadius, 1.0 / variance) * radius_factor, kMinRadius, kMaxRadius);
}

double ProximalWeight(double kappa, double mean_diagonal, double relative_noise) {
  return kappa * mean_diagonal * (1.0 + 16.0 * relative_noise * relative_noise);
}

void AdaptStepControl(const SolveOutcome& outcome, bool keeps_radius, FitState& state) {
  double damping_change = 1.0;
  double radius_change = 1.0;
  if (!outcome.accepted) {
    damping_change = 2.0;
    radius_change = 0.5;
    ++state.rejected_in_row;
  } else {
    state.rejected_in_row = 0;
    if (outcome.trials > 1 || outcome.relative_decrease < kPoorStep) {
      damping_change = 2.0;
      radius_change = 0.5;
    } else if (outcome.relative_decrease > kGoodStep) {
      damping_change = 0.25;
      radius_change = 2.0;
    }
  }
  state.step_share = outcome.step_share;
  state.damping = std::clamp(state.damping * damping_change, kMinDamping, kMaxDamping);
  double factor = state.radius_factor;
  if (keeps_radius) {
    // The trials have shrunk it as far as they had to, and further.
    factor = outcome.radius / kMaxRadius;
    if (outcome.accepted) {
      radius_change = outcome.relative_decrease > kGoodStep ? kWidening : 1.0;
    }
  }
  state.radius_factor = std::clamp(factor * radius_change, 1e-8, 1.0);
}

std::string StopReason(const StageSpec& stage, const FitState& state, int num_levels) {
  if (state.round >= stage.max_rounds) {
    return "max_rounds";
  }
  if (state.rejected_in_row >= kMaxRejectedRounds) {
    return "no step accepted in " + std::to_string(kMaxRejectedRounds) + " rounds";
  }
  const bool last = state.level + 1 >= num_levels;
  // The finest level gets its share of the rounds, and what the others leave.
  if (!last && state.RoundsOfLevel() >= LevelShare(stage, num_levels)) {
    return "the level's share of max_rounds";
  }
  if (last && state.within_error >= kRoundsWithinError && state.precise) {
    return "converged: the last steps were within their error";
  }
  if (last && stage.stop_relative_cost > 0.0 && state.within_error >= kRoundsOfChance) {
    return "the last steps were within their error, which falls slowly";
  }
  if (!last && state.still >= kRoundsWithinError) {
    return "nothing moves at this scale";
  }
  if (state.flat >= kSignsOfEnd) {
    return "cost no longer falls";
  }
  if (state.rounds.model.Empty() && stage.stop_relative_cost > 0.0) {
    const double least =
        last ? stage.stop_relative_cost : std::max(stage.stop_relative_cost, kFallOfCoarseLevels);
    if (NoLongerFalls(state.costs, least)) {
      return "cost no longer falls";
    }
    if (NoLongerFalls(state.held_out_costs, least)) {
      return "held-out photos gain no more";
    }
    if (last && RunsShortOfSamples(stage, state)) {
      return "max_spp samples gain little more";
    }
  }
  return "";
}

bool NoLongerFalls(const std::vector<double>& costs, double least) {
  const std::size_t count = costs.size();
  return count >= 2 * kStopWindow &&
         MeanOf(costs, count) > (1.0 - least) * MeanOf(costs, count - kStopWindow);
}

bool NoLongerFalls(const std::vector<double>& costs, double least, double over_noise) {
  if (NoLongerFalls(costs, least)) {
    return true;
  }
  const double of_round = least / kStopWindow;
  return costs.size() >= 2 && std::numbers::sqrt2 < of_round * over_noise &&
         costs.back() > (1.0 - of_round) * costs[costs.size() - 2];
}

void AddIterate(AverageState& average,
                int round,
                double weight,
                const ParameterSet& set,
                const renderer::Scene& scene) {
  if (average.newer.weight > 0.0 && !SameShapes(average.newer.scene, scene)) {
    average = {{}, {}, round};
  } else if (round >= 2 * average.newer_start) {
    average.older = std::exchange(average.newer, {});
    average.newer_start = round;
  }
  const WeightedScene one{weight, scene};
  average.newer = average.newer.weight > 0.0 ? Mean(average.newer, one, set) : one;
}

WeightedScene AverageIterate(const AverageState& average, const ParameterSet& set) {
  return average.older.weight > 0.0 ? Mean(average.older, average.newer, set) : average.newer;
}

}  // namespace pathfit::optim
