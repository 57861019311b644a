// Many rounds of a fit whose noise is known: what their halves give is unbiased.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "optim/problem/image_problem.h"
#include "optim/problem/quadratic_model.h"
#include "tests/optim/problem/linear_rounds.h"

namespace pathfit::split_halves_test {
namespace {

using optim::ImageProblem;
using optim::QuadraticModel;
using tests::LinearImageSource;
using tests::LinearRounds;

constexpr double kOpen = std::numeric_limits<double>::infinity();

TEST_F(LinearRounds, SplitHalvesLeaveTheGradientAtTheTruthUnbiased) {
  // At the truth, the mean of all images is the photo: the expected gradient is zero. Halves that
  // share their samples would have a gradient of noise^2 times the image instead.
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.5);
  constexpr int kNumSeeds = 200;
  double mean_along_truth = 0.0, square = 0.0, shared = 0.0;
  for (int s = 0; s < kNumSeeds; ++s) {
    const auto seed = static_cast<std::uint64_t>(s);
    optim::ImageProblemOptions options = OptionsOf(seed);
    double along[2] = {0.0, 0.0};
    for (int use_shared = 0; use_shared < 2; ++use_shared) {
      if (use_shared == 1) {
        options.samples.b = options.samples.a;
      }
      ImageProblem problem(source, fit_.views, set_, options);
      problem.Linearize(fit_.truth);
      for (std::size_t i = 0; i < fit_.truth.size(); ++i) {
        along[use_shared] += problem.sums().gradient[i] * fit_.truth[i];
      }
    }
    mean_along_truth += along[0] / kNumSeeds;
    square += along[0] * along[0] / kNumSeeds;
    shared += along[1] / kNumSeeds;
  }
  const double sigma = std::sqrt((square - mean_along_truth * mean_along_truth) / kNumSeeds);
  EXPECT_LT(std::abs(mean_along_truth), 4.0 * sigma);
  EXPECT_LT(sigma, 0.02 * shared);  // the noise of this test could not hide the bias
}

TEST_F(LinearRounds, SplitHalfCostIsUnbiased) {
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.5);
  constexpr int kNumSeeds = 200;
  double mean = 0.0, square = 0.0, noise = 0.0;
  for (int s = 0; s < kNumSeeds; ++s) {
    ImageProblem problem(source, fit_.views, set_, OptionsOf(static_cast<std::uint64_t>(s)));
    problem.Linearize(fit_.truth);
    mean += problem.costs().Total() / kNumSeeds;
    square += problem.costs().Total() * problem.costs().Total() / kNumSeeds;
    noise += 0.5 * problem.costs().signal_squared / kNumSeeds;
  }
  const double sigma = std::sqrt((square - mean * mean) / kNumSeeds);
  EXPECT_LT(std::abs(mean), 4.0 * sigma);
  EXPECT_LT(sigma, 0.02 * noise);
}

TEST_F(LinearRounds, NoiseOfTheJacobianInflatesItsSquareButNotTheProductOfHalves) {
  LinearImageSource exact(32, 16, tests::kNumBlocks, 4, 0.0);
  const std::size_t n = set_.NumScalars();
  const double truth = Trace(Linearized(exact, start_, 0).model().product, n);
  LinearImageSource noisy(32, 16, tests::kNumBlocks, 4, 1.0);
  constexpr int kRounds = 100;
  double product = 0.0, square_of_product = 0.0, square = 0.0;
  for (std::uint64_t r = 0; r < kRounds; ++r) {
    const ImageProblem problem = Linearized(noisy, start_, r);
    const double one = Trace(problem.model().product, n);
    product += one / kRounds;
    square_of_product += one * one / kRounds;
    square += Trace(problem.model().square, n) / kRounds;
  }
  const double error = std::sqrt((square_of_product - product * product) / kRounds);
  EXPECT_LT(std::abs(product - truth), 4.0 * error);
  EXPECT_LT(error, 0.01 * truth);
  EXPECT_GT(square, 1.2 * truth);
}

TEST_F(LinearRounds, RoundsAddUpAtConstantSamples) {
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.5);
  optim::RoundSums rounds;
  std::vector<double> theta = start_;
  double alone = 0.0;
  constexpr int kRounds = 32;
  for (std::uint64_t r = 0; r < kRounds; ++r) {
    ImageProblem single = Linearized(source, theta, r);
    alone += Error(Solve(single, theta).theta) / kRounds;
    ImageProblem problem = Linearized(source, theta, r, &rounds);
    const optim::SolveOutcome outcome = Solve(problem, theta);
    ASSERT_TRUE(outcome.accepted);
    rounds = problem.TakeRounds();
    std::vector<double> step = outcome.theta;
    for (std::size_t i = 0; i < step.size(); ++i) {
      step[i] -= theta[i];
    }
    rounds.Forget(step);
    theta = outcome.theta;
  }
  // The square root of 32 is 5.7; the first rounds, from afar, are forgotten.
  EXPECT_LT(Error(theta), 0.33 * alone);
  EXPECT_GT(rounds.model.weight, 0.5 * kRounds);
}

TEST_F(LinearRounds, ErrorsOfTheMinimumAreThoseOfItsScatter) {
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.5);
  const std::size_t n = set_.NumScalars();
  std::vector<double> mean(n), square(n), predicted(n), of_photos(n);
  constexpr int kRounds = 200;
  const std::vector<double> truth = set_.ThetaFromValues(fit_.truth);
  const std::vector<double> open(n, kOpen);
  for (std::uint64_t r = 0; r < kRounds; ++r) {
    ImageProblem problem = Linearized(source, truth, r);
    const QuadraticModel& model = problem.model();
    const optim::StandardErrors errors =
        optim::EstimateErrors(model, std::vector<double>(n * n), std::vector<double>(n * n), open);
    const std::vector<double> step = optim::FindMinimum(model,
                                                        truth,
                                                        std::vector<double>(n * n),
                                                        std::vector<double>(n),
                                                        std::vector<bool>(n, true))
                                         .step;
    for (std::size_t i = 0; i < n; ++i) {
      mean[i] += step[i] / kRounds;
      square[i] += step[i] * step[i] / kRounds;
      predicted[i] += errors.of_rendering[i] * errors.of_rendering[i] / kRounds;
      of_photos[i] += errors.of_photos[i] / kRounds;
    }
  }
  double ratio = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    ratio += std::sqrt((square[i] - mean[i] * mean[i]) / predicted[i]) / static_cast<double>(n);
    EXPECT_LT(of_photos[i], std::sqrt(predicted[i])) << "the photos are the truth";
  }
  EXPECT_GT(ratio, 0.8);
  EXPECT_LT(ratio, 1.25);  // the matrix has noise, too
}

TEST_F(LinearRounds, TheGradientsCovarianceIsItsScatterFarFromTheTruth) {
  // Value and derivative of a pixel share their noise: exchanged halves would show a quarter of the
  // variance where all is a half too bright, and three times as much where it is a fifth too dark.
  const std::size_t n = set_.NumScalars();
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.05);
  for (const double brightness : {0.8, 1.5, 2.0}) {
    std::vector<double> theta = set_.ThetaFromValues(fit_.truth);
    for (double& x : theta) {
      x *= brightness;
    }
    std::vector<double> mean(n), square(n);
    double predicted = 0.0;
    constexpr int kRounds = 100;
    for (std::uint64_t r = 0; r < kRounds; ++r) {
      const ImageProblem problem = Linearized(source, theta, r);
      for (std::size_t i = 0; i < n; ++i) {
        const double gradient = problem.sums().gradient[i];
        mean[i] += gradient / kRounds;
        square[i] += gradient * gradient / kRounds;
      }
      predicted += Trace(problem.model().covariance, n) / kRounds;
    }
    double seen = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      seen += (square[i] - mean[i] * mean[i]) * kRounds / (kRounds - 1);
    }
    EXPECT_NEAR(predicted / seen, 1.0, 0.1) << brightness;  // 126 scalars of 100 rounds
  }
}

}  // namespace
}  // namespace pathfit::split_halves_test
