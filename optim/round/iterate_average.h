#pragma once

#include <vector>

#include "optim/checkpoint/fit_state.h"

namespace pathfit::optim {

/// Adds the iterate after round `round` (from 1) with the round's samples as weight.
void AddIterate(AverageState& average, int round, double weight, const std::vector<double>& theta);

/// The mean over the last half to three quarters of the rounds; empty before the first.
std::vector<double> AverageIterate(const AverageState& average);

}  // namespace pathfit::optim
