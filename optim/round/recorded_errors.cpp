#include "optim/round/recorded_errors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "optim/problem/image_problem.h"
#include "optim/round/round_policy.h"
#include "optim/solver/sparse_step.h"

namespace pathfit::optim {
namespace {

// Errors that leave a number anywhere between its bounds, in their standard deviation.
constexpr double kAnywhere = 0.95;
constexpr double kRelativeStep = 1e-4;  // of theta
constexpr double kUntold = std::numeric_limits<double>::infinity();

/// d value / d theta of each scalar by itself, without sign.
std::vector<double> SlopesOfValues(const ParameterSet& set, const std::vector<double>& theta) {
  const std::vector<double> values = set.ValuesFromTheta(theta);
  std::vector<double> slopes(theta.size());
  // By differences, since what a scalar stands for may depend on another group (cones).
  std::vector<double> moved = theta;
  for (const renderer::ParameterGroup& group : set.layout().groups()) {
    const auto first = static_cast<std::size_t>(group.first_scalar);
    const auto size = static_cast<std::size_t>(group.block_size);
    const std::size_t end = first + group.NumScalars();
    for (std::size_t c = 0; c < size; ++c) {
      for (std::size_t i = first + c; i < end; i += size) {
        moved[i] += kRelativeStep * std::max(1.0, std::abs(theta[i]));
      }
      const std::vector<double> there = set.ValuesFromTheta(moved);
      for (std::size_t i = first + c; i < end; i += size) {
        slopes[i] =
            std::abs(there[i] - values[i]) / (kRelativeStep * std::max(1.0, std::abs(theta[i])));
        moved[i] = theta[i];
      }
    }
  }
  return slopes;
}

/// error(scalar) for all of them.
template <class Error>
void RecordScalars(const ParameterSet& set, RecordedErrors& recorded, Error error) {
  for (const renderer::ParameterGroup& group : set.layout().groups()) {
    std::vector<double>& of_group = recorded[group.name];
    of_group.clear();
    const auto first = static_cast<std::size_t>(group.first_scalar);
    for (std::size_t i = first; i < first + group.NumScalars(); ++i) of_group.push_back(error(i));
  }
}

}  // namespace

void RecordErrors(const ParameterSet& set,
                  const std::vector<double>& theta,
                  const StandardErrors& errors,
                  RecordedErrors& recorded) {
  const std::vector<double> slopes = SlopesOfValues(set, theta);
  RecordScalars(set, recorded, [&](std::size_t i) {
    const double told =
        std::hypot(errors.of_rendering[i], errors.of_photos[i], errors.of_beliefs[i]);
    const double of_theta = std::hypot(told, errors.of_ranges[i]);
    const double between_bounds = (set.Upper(i) - set.Lower(i)) / std::sqrt(12.0);
    // Without bounds of its own it lies as far away as those of others let it.
    const bool is_led = std::isinf(between_bounds) && errors.of_ranges[i] > told;
    const bool is_anywhere = is_led || of_theta >= kAnywhere * between_bounds;
    return is_anywhere ? kUntold : slopes[i] * of_theta;
  });
}

void RecordUnseen(const ParameterSet& set,
                  const std::vector<double>& diagonal,
                  RecordedErrors& recorded) {
  RecordScalars(set, recorded, [&](std::size_t i) {
    return diagonal[i] > 0.0 ? std::numeric_limits<double>::quiet_NaN() : kUntold;
  });
}

void RecordErrorsOfMany(const StageContext& context,
                        ImageSource& source,
                        const FitState& state,
                        RecordedErrors& recorded) {
  if (!ImageProblem::FormsSparseNormalEquations(context.spec.linear_solver,
                                                context.set.NumScalars()) ||
      PairedBlocks(context.set).NumSpreadScalars() > 0) {
    return;
  }
  const StageSpec& stage = context.spec.stages[static_cast<std::size_t>(context.stage)];
  ImageProblemOptions options;
  options.loss = context.spec.loss;
  options.linear_solver = context.spec.linear_solver;
  options.max_memory_bytes = context.spec.max_memory_bytes;
  // A round of its own: those of the stage are counted from 1, its reports' is 0.
  options.samples = MakeHalves(context.spec.seed,
                               context.stage,
                               stage.max_rounds + 1,
                               SampleUse::kEvaluation,
                               BudgetOfRound(context, state));
  options.draws_gradients = true;
  options.division = &context.division;
  ImageProblem problem(source, context.views, context.set, options);
  const std::vector<double> theta =
      context.set.ThetaFromValues(context.set.layout().Gather(state.scene));
  problem.Linearize(context.set.ValuesFromTheta(theta));
  if (!context.division.IsFirst()) {
    return;
  }
  const double residual =
      std::sqrt(2.0 * std::max(0.0, problem.costs().Total()) / context.views.num_channels);
  RecordErrors(
      context.set, theta, EstimateErrorsOfMany(problem, context.priors, theta, residual), recorded);
}

}  // namespace pathfit::optim
