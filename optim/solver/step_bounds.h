#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "optim/parameter/parameter_set.h"

namespace pathfit::optim {

/// What is linear in a value is not linear in its logarithm: a step changes it fourfold at most.
inline constexpr double kLargestLogStep = 1.386;

/// Where a step from `theta` may lead a scalar: lower and upper end, infinite where there is none.
inline std::pair<double, double> BoundsOfStep(const ParameterSet& set,
                                              const std::vector<double>& theta,
                                              std::size_t scalar) {
  const double lower = set.Lower(scalar);
  const double upper = set.Upper(scalar);
  const double at = theta[scalar];
  const double factor = set.LargestFactor(scalar);
  if (set.IsLog(scalar)) {
    const double most = std::min(kLargestLogStep, std::log(factor));
    return {std::max(lower, at - most), std::min(upper, at + most)};
  }
  if (std::isinf(factor)) {
    return {lower, upper};
  }
  return {std::max(lower, at / factor), std::min(upper, at * factor)};
}

}  // namespace pathfit::optim
