#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "optim/parameter/parameter_set.h"

namespace pathfit::optim {

/// What is linear in a value is not linear in its logarithm: a step changes it fourfold at most.
inline constexpr double kLargestLogStep = 1.386;

/// Where a model made at `at` holds for a scalar: lower and upper end, infinite where there is
/// none.
inline std::pair<double, double> ReachOfModel(const ParameterSet& set,
                                              double at,
                                              std::size_t scalar) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double factor = set.LargestFactor(scalar);
  if (set.IsLog(scalar)) {
    const double most = std::min(kLargestLogStep, std::log(factor));
    return {at - most, at + most};
  }
  return std::isinf(factor) ? std::pair{-kInfinity, kInfinity}
                            : std::pair{at / factor, at * factor};
}

/// Where a step from `theta` may lead a scalar: that, and within its bounds.
inline std::pair<double, double> BoundsOfStep(const ParameterSet& set,
                                              const std::vector<double>& theta,
                                              std::size_t scalar) {
  const auto [lower, upper] = ReachOfModel(set, theta[scalar], scalar);
  return {std::max(set.Lower(scalar), lower), std::min(set.Upper(scalar), upper)};
}

}  // namespace pathfit::optim
