#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/image_problem.h"
#include "optim/problem/round_sums.h"
#include "optim/solver/trust_region_solver.h"
#include "tests/optim/problem/linear_image_source.h"

namespace pathfit::tests {

/// Rounds of a fit of images that are linear in what is fitted.
class LinearRounds : public testing::Test {
 protected:
  static optim::ImageProblemOptions OptionsOf(std::uint64_t round) {
    optim::ImageProblemOptions options;
    options.linear_solver = optim::LinearSolverChoice::kGram;
    options.samples = {{{.spp = 1}, 2 * round + 1}, {{.spp = 1}, 2 * round + 2}};
    return options;
  }

  [[nodiscard]] optim::ImageProblem Linearized(LinearImageSource& source,
                                               const std::vector<double>& theta,
                                               std::uint64_t round,
                                               const optim::RoundSums* earlier = nullptr) const {
    optim::ImageProblemOptions options = OptionsOf(round);
    options.earlier = earlier;
    optim::ImageProblem problem(source, fit_.views, set_, options);
    problem.Linearize(set_.ValuesFromTheta(theta));
    return problem;
  }

  [[nodiscard]] double Error(const std::vector<double>& theta) const {
    const std::vector<double> values = set_.ValuesFromTheta(theta);
    double sum = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      sum += (values[i] - fit_.truth[i]) * (values[i] - fit_.truth[i]);
    }
    return std::sqrt(sum / static_cast<double>(values.size()));
  }

  static double Trace(const std::vector<double>& matrix, std::size_t n) {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      sum += matrix[i * n + i];
    }
    return sum;
  }

  static optim::SolveOutcome Solve(optim::ImageProblem& problem, const std::vector<double>& theta) {
    optim::SolveOptions options;
    options.radius = 1e4;
    return optim::SolveRound(problem, {}, {}, theta, options);
  }

  LinearFit fit_ = MakeLinearFit(32, 16, 2, 4);
  optim::ParameterSet set_{fit_.scene, fit_.unknowns, {0}, {}, {}};
  std::vector<double> start_ = std::vector<double>(fit_.truth.size(), 1.0);
};

}  // namespace pathfit::tests
