#pragma once

#include <algorithm>
#include <vector>

#include "optim/parameter/parameter_set.h"

namespace pathfit::optim {

/// What is linear in a value is not linear in its logarithm: a step changes it fourfold at most.
inline constexpr double kLargestLogStep = 1.386;

/// Where a step from `theta` may lead, by scalar; infinite where there is no bound.
struct StepBounds {
  StepBounds(const ParameterSet& set, const std::vector<double>& theta)
      : lower(set.lower()), upper(set.upper()) {
    for (std::size_t i = 0; i < theta.size(); ++i) {
      if (set.IsLog(i)) {
        lower[i] = std::max(lower[i], theta[i] - kLargestLogStep);
        upper[i] = std::min(upper[i], theta[i] + kLargestLogStep);
      }
    }
  }
  std::vector<double> lower, upper;
};

}  // namespace pathfit::optim
