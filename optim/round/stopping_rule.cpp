#include "optim/round/stopping_rule.h"

#include <cstddef>

namespace pathfit::optim {
namespace {

double MeanOf(const std::vector<double>& costs, std::size_t end) {
  double sum = 0.0;
  for (std::size_t i = end - kStopWindow; i < end; ++i) {
    sum += costs[i] / kStopWindow;
  }
  return sum;
}

}  // namespace

std::string StopReason(const StageSpec& stage, const FitState& state) {
  if (state.round >= stage.max_rounds) {
    return "max_rounds";
  }
  if (state.rejected_in_row >= kMaxRejectedRounds) {
    return "no step accepted in " + std::to_string(kMaxRejectedRounds) + " rounds";
  }
  const std::size_t count = state.costs.size();
  if (stage.stop_relative_cost > 0.0 && count >= 2 * kStopWindow) {
    const double before = MeanOf(state.costs, count - kStopWindow);
    const double now = MeanOf(state.costs, count);
    if (now > (1.0 - stage.stop_relative_cost) * before) {
      return "cost no longer falls";
    }
  }
  return "";
}

}  // namespace pathfit::optim
