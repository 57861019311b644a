#include "optim/round/persistence.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "renderer/core/error.h"

namespace pathfit::optim {

std::string FitFingerprint(const FitSpec& spec,
                           const ParameterSet& all_unknowns,
                           const ObservationSet& observations) {
  std::ostringstream text;
  text << "seed " << spec.seed << "; views " << observations.views.size() << " (held out:";
  for (std::size_t i = 0; i < observations.views.size(); ++i) {
    if (observations.views[i].validation) {
      text << ' ' << i;
    }
  }
  text << "); stages";
  for (const StageSpec& stage : spec.stages) {
    text << " '" << stage.name << "' at " << stage.image_scale
         << (stage.coarse_to_fine ? " from coarse" : "") << " free";
    for (const int index : stage.free) {
      text << ' ' << index;
    }
    text << ',';
  }
  text << " unknowns";
  for (const renderer::ParameterGroup& group : all_unknowns.layout().groups()) {
    text << ' ' << group.name << '[' << group.num_blocks << ']';
  }
  return text.str();
}

void ValidateState(const FitState& state, const FitSpec& spec, const std::string& fingerprint) {
  if (state.fingerprint != fingerprint) {
    throw renderer::IoError(
        "the checkpoint belongs to another experiment: views, unknowns, stages or seed differ "
        "(checkpoint: " +
        state.fingerprint + "; now: " + fingerprint + ")");
  }
  const auto require = [](bool holds, const std::string& what) {
    if (!holds) {
      throw renderer::IoError("the checkpoint is not one of this program: " + what);
    }
  };
  const auto num_stages = static_cast<int>(spec.stages.size());
  require(state.stage >= 0 && state.stage <= num_stages,
          "stage " + std::to_string(state.stage) + "; allowed: 0 to " + std::to_string(num_stages));
  require(state.round >= 0 && state.step >= state.round && state.sequence >= 0 &&
              state.rejected_in_row >= 0 && state.average.newer_start >= 1 && state.level >= 0 &&
              state.level_start >= 0 && state.restarts >= 0 && state.level_start <= state.round &&
              state.accepted >= 0 && state.accepted <= state.round && state.growths >= 0 &&
              state.growths <= state.round && state.within_error >= 0 && state.still >= 0 &&
              state.flat >= 0 && state.average.newer_start <= std::max(1, state.RoundsOfLevel()),
          "a count of rounds out of range");
  require(state.stage < num_stages || state.round == 0, "rounds after the last stage");
  require(state.wall_s >= 0.0 && std::isfinite(state.wall_s) && state.radius_factor > 0.0 &&
              std::isfinite(state.promised_cost) && std::isfinite(state.radius_factor) &&
              state.step_share > 0.0 && state.step_share <= 1.0 && state.damping > 0.0 &&
              std::isfinite(state.damping),
          "step control or time out of range");
  for (const auto budget : renderer::kBoundaryBudgets) {
    require(state.split.*budget > 0.0 && std::isfinite(state.split.*budget),
            "a split of samples out of range");
  }
  require(HasWeightsOfRounds(state.average, state.RoundsOfLevel()),
          "averages with the weights of no rounds");
  const auto all_finite = [](const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
  };
  require(state.costs.size() == static_cast<std::size_t>(state.RoundsOfLevel()) &&
              all_finite(state.costs),
          "costs that are not one finite number per round");
  require(state.held_out_costs.size() <= state.costs.size() && all_finite(state.held_out_costs),
          "costs of held-out photos that are not at most one finite number per round");
  const auto is_model = [&](const QuadraticModel& model) {
    const std::size_t n = model.NumScalars();
    const auto is_square = [&](const std::vector<double>& matrix) {
      return matrix.size() == n * n && all_finite(matrix);
    };
    return model.weight >= 0.0 && std::isfinite(model.weight) && is_square(model.product) &&
           is_square(model.square) && is_square(model.covariance) && is_square(model.scatter) &&
           all_finite(model.linear) && model.variance.size() == n && all_finite(model.variance);
  };
  const RoundSums& rounds = state.rounds;
  require(is_model(rounds.model) && is_model(rounds.apart) && rounds.rows.IsValid() &&
              (rounds.apart.Empty() || rounds.apart.NumScalars() == rounds.model.NumScalars()) &&
              (rounds.rows.Empty() || rounds.rows.theta.size() == rounds.model.NumScalars()),
          "accumulated models or rows that are none");
  for (const auto& [name, values] : state.standard_errors) {
    require(std::none_of(values.begin(), values.end(), [](double x) { return x < 0.0; }),
            "standard errors of '" + name + "' that are none");
  }
}

}  // namespace pathfit::optim
