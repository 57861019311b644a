#pragma once

#include <string>
#include <vector>

namespace pathfit::optim {

/// Running sums of a sample-weighted mean over recent rounds: two windows, the older replaced by
/// the newer whenever the number of rounds doubles, so that together they cover the last half to
/// three quarters.
struct AverageState {
  std::vector<double> older_sum,
      newer_sum;  ///< of weight * theta, in the stage's order of unknowns
  double older_weight = 0.0, newer_weight = 0.0;
  int newer_start = 1;  ///< round from which the newer window counts
};

/// Everything a fit needs to continue to the same bits, besides the scene it started from and its
/// specification. Parameter vectors are values in units of the scene, in the order of all unknowns
/// that are not held.
struct FitState {
  std::string fingerprint;  ///< of the specification; a state of another one is refused
  int sequence = 0;         ///< counts written states
  int step = 0;             ///< finished rounds of all stages
  int stage = 0;            ///< the current stage; the number of stages when the fit is finished
  int round = 0;            ///< finished rounds of the current stage
  double wall_s = 0.0;

  double radius_factor = 1.0;  ///< on the noise-derived trust radius, shrunk by rejections
  double damping = 0.0;        ///< kappa of the proximal metric (round/step_control.h)
  int rejected_in_row = 0;
  std::vector<double> costs;  ///< of the stage's rounds, at their start

  std::vector<double> current, stage_start;
  AverageState average;
};

}  // namespace pathfit::optim
