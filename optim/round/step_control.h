#pragma once

#include "optim/checkpoint/fit_state.h"
#include "optim/problem/split_half_cost.h"
#include "optim/solver/trust_region_solver.h"

namespace pathfit::optim {

/// Relative noise of the residual: rms of the half difference over rms of the mean, 0..1 or so.
double RelativeNoise(const ImageCosts& costs);

/// Trust radius of a round: 1 / noise^2, times the factor that rejections leave behind. The noise
/// is that of the mean of both halves. Measured on synthetic fits of shape, colours and light: 1 /
/// (16 noise^2) leaves 4 to 6 times the shape error after the same rounds, 6 / noise^2 spoils badly
/// determined texels.
double TrustRadius(double relative_noise, double radius_factor);

/// Weight mu of the proximal metric: kappa times the mean diagonal of J^T J over the moving
/// coordinates, raised with the noise like the solver's own damping.
double ProximalWeight(double kappa, double mean_diagonal, double relative_noise);

inline constexpr double kStartDamping = 1e-3;  ///< kappa in a stage's first round

/// Adapts radius_factor, kappa and the count of rejections to how the round went: a step that did
/// what the model said loosens both, a poor one or a rejection tightens them.
void AdaptStepControl(const SolveOutcome& outcome, FitState& state);

}  // namespace pathfit::optim
