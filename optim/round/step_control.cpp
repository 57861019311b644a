#include "optim/round/step_control.h"

#include <algorithm>
#include <cmath>

namespace pathfit::optim {
namespace {

constexpr double kMinRadius = 1e-4;
constexpr double kMaxRadius = 1e4;
constexpr double kMinDamping = 1e-6;
constexpr double kMaxDamping = 1e2;
constexpr double kGoodStep = 0.75;  // actual over predicted decrease
constexpr double kPoorStep = 0.25;

}  // namespace

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

void AdaptStepControl(const SolveOutcome& outcome, FitState& state) {
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
  state.damping = std::clamp(state.damping * damping_change, kMinDamping, kMaxDamping);
  state.radius_factor = std::clamp(state.radius_factor * radius_change, 1e-4, 1.0);
}

}  // namespace pathfit::optim
