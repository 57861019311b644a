#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "optim/problem/image_problem.h"
#include "optim/solver/sparse_step.h"
#include "renderer/core/parallel.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/optim/problem/linear_image_source.h"

namespace pathfit::sparse_errors_test {
namespace {

using optim::ImageProblem;
using optim::LinearSolverChoice;
using optim::PriorTerm;
using optim::StandardErrors;
using tests::LinearFit;
using tests::LinearImageSource;

constexpr double kPhotoNoise = 0.05;
// Of a mean square of 126 scalars, each known from kCount draws to sqrt(2 / kCount), where the
// draws of neighbours go along with each other: four standard deviations of 42 independent ones.
const double kTolerance = 4.0 * std::sqrt(2.0 / optim::GradientDraws::kCount / 42.0);

class SparseErrorsTest : public testing::Test {
 protected:
  SparseErrorsTest() {
    for (std::size_t v = 0; v < fit_.views.levels.size(); ++v) {
      optim::ViewLevel level = fit_.views.levels[v].Unpack();
      renderer::CounterRng rng(3, renderer::RandomDomain::kOwnSeed, v);
      for (float& x : level.photo.data) {
        x += static_cast<float>(kPhotoNoise * std::sqrt(12.0) * (rng.Next() - 0.5));
      }
      fit_.views.levels[v] = optim::PackedLevel(level);
    }
  }

  ImageProblem Linearized(LinearSolverChoice solver) { return Linearized(solver, fit_.truth); }
  ImageProblem Linearized(LinearSolverChoice solver, const std::vector<double>& theta) {
    optim::ImageProblemOptions options;
    options.linear_solver = solver;
    options.samples = {{{.spp = 1}, 1}, {{.spp = 1}, 2}};
    options.draws_gradients = solver == LinearSolverChoice::kSparseGram;
    ImageProblem problem(source_, fit_.views, set_, options);
    problem.Linearize(theta);
    return problem;
  }

  StandardErrors OfMany(const std::vector<PriorTerm>& priors) {
    ImageProblem problem = Linearized(LinearSolverChoice::kSparseGram);
    return optim::EstimateErrorsOfMany(problem, priors, fit_.truth, kPhotoNoise);
  }

  LinearFit fit_ = tests::MakeLinearFit(48, 32, 3, 4);
  optim::ParameterSet set_{fit_.scene, fit_.unknowns, {0}, {}, {}};
  LinearImageSource source_{48, 32, tests::kNumBlocks, 4, 0.0};
};

TEST_F(SparseErrorsTest, AreThoseOfDenseNormalEquations) {
  const std::size_t n = fit_.truth.size();
  const ImageProblem dense = Linearized(LinearSolverChoice::kGram);
  const std::vector<double> none(n * n), ranges(n, std::numeric_limits<double>::infinity());
  const StandardErrors expected = optim::EstimateErrors(dense.model(), none, none, ranges);
  const StandardErrors found = OfMany({});
  double sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    ASSERT_GT(expected.of_photos[i], 0.0);
    EXPECT_EQ(found.of_ranges[i], 0.0);
    const double ratio = found.of_photos[i] / expected.of_photos[i];
    sum += ratio * ratio;
  }
  EXPECT_NEAR(sum / static_cast<double>(n), 1.0, kTolerance);
}

// A fit that ends early is as far off as its gradient says.
TEST_F(SparseErrorsTest, TheRestOfTheWayCounts) {
  constexpr double kWay = 1.0;  // many errors
  std::vector<double> theta = fit_.truth;
  for (double& x : theta) x += kWay;
  ImageProblem problem = Linearized(LinearSolverChoice::kSparseGram, theta);
  const StandardErrors found = optim::EstimateErrorsOfMany(problem, {}, theta, kPhotoNoise);
  double sum = 0.0;
  for (const double error : found.of_photos) sum += error;
  // Far away, the shares' signs draw larger errors, too, beyond which it counts.
  EXPECT_GT(sum / static_cast<double>(theta.size()), 0.6 * kWay);
  EXPECT_LT(sum / static_cast<double>(theta.size()), 1.2 * kWay);
}

// What only a prior tells is as uncertain as the prior says, not certain.
TEST_F(SparseErrorsTest, PriorsLeaveWhatTheySay) {
  constexpr double kWeight = 1e4;
  for (const double belief : {0.0, optim::kGaussianResidual}) {
    std::vector<PriorTerm> priors;
    for (std::size_t b = 0; b < set_.NumBlocks(); ++b) {
      PriorTerm term;
      term.blocks = {static_cast<std::int32_t>(b)};
      term.weights = {kWeight};
      for (std::size_t c = 0; c < 3; ++c) term.offset[c] = kWeight * fit_.truth[3 * b + c];
      term.belief = belief;
      priors.push_back(term);
    }
    const StandardErrors found = OfMany(priors);
    const double expected = (belief > 0.0 ? belief : kPhotoNoise) / kWeight;
    double sum = 0.0;
    for (const double error : found.of_photos) sum += error * error / (expected * expected);
    EXPECT_NEAR(sum / static_cast<double>(fit_.truth.size()), 1.0, kTolerance);
  }
}

TEST_F(SparseErrorsTest, WhatNoPixelShowsIsInfinite) {
  fit_.views.fitted = {};
  EXPECT_TRUE(std::isinf(OfMany({}).of_ranges.front()));
}

TEST_F(SparseErrorsTest, DoNotDependOnThreads) {
  std::vector<std::vector<double>> errors;
  for (const int threads : {1, 4}) {
    const renderer::ThreadLimit limit(threads);
    errors.push_back(OfMany({}).of_photos);
  }
  EXPECT_EQ(errors[0], errors[1]);
}

}  // namespace
}  // namespace pathfit::sparse_errors_test
