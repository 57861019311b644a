#include "optim/problem/quadratic_model.h"

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "optim/problem/image_problem.h"
#include "optim/solver/trust_region_solver.h"
#include "tests/optim/problem/linear_rounds.h"

namespace pathfit::quadratic_model_test {
namespace {

using optim::ImageProblem;
using optim::QuadraticModel;
using tests::LinearImageSource;

constexpr double kOpen = std::numeric_limits<double>::infinity();

using QuadraticModelTest = tests::LinearRounds;

TEST_F(QuadraticModelTest, PhotosOfMorePixelsChangeNeitherTheMinimumNorItsErrors) {
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.5);
  const std::size_t n = set_.NumScalars();
  const std::vector<double> truth = set_.ThetaFromValues(fit_.truth);
  const QuadraticModel small = Linearized(source, truth, 0).model();
  QuadraticModel large = small;
  constexpr double kRatio = 16.0;
  optim::CarryToPhotosOfMorePixels(kRatio, large);
  const std::vector<double> none(n * n);
  const std::vector<double> open(n, kOpen);
  const optim::StandardErrors of_small = optim::EstimateErrors(small, none, none, open);
  const optim::StandardErrors of_large = optim::EstimateErrors(large, none, none, open);
  const std::vector<bool> no_logs(truth.size(), false);
  const optim::ModelAtPoint at_small = optim::MakeModelAtPoint(small, truth, no_logs);
  const optim::ModelAtPoint at_large = optim::MakeModelAtPoint(large, truth, no_logs);
  const auto near = [](double expected, double found) {
    EXPECT_NEAR(found, expected, 1e-6 * std::abs(expected) + 1e-12);
  };
  for (std::size_t i = 0; i < n; ++i) {
    near(of_small.of_rendering[i], of_large.of_rendering[i]);
    near(of_small.of_photos[i], of_large.of_photos[i]);
    near(kRatio * at_small.gradient[i], at_large.gradient[i]);
    near(kRatio * at_small.hessian[i * n + i], at_large.hessian[i * n + i]);
  }
}

TEST_F(QuadraticModelTest, PriorsMakeErrorsSmaller) {
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.5);
  const std::size_t n = set_.NumScalars();
  const QuadraticModel model = Linearized(source, start_, 0).model();
  std::vector<double> prior(n * n), belief(n * n);
  const std::vector<double> open(n, kOpen);
  const optim::StandardErrors free = optim::EstimateErrors(model, prior, belief, open);
  EXPECT_EQ(free.of_beliefs[0], 0.0);
  // A belief of standard deviation 0.01 that decides alone is as wrong as it says.
  prior[0] = 1e9;
  belief[0] = 1e9 * 1e9 * 0.01 * 0.01;
  const optim::StandardErrors held = optim::EstimateErrors(model, prior, belief, open);
  EXPECT_LT(held.of_rendering[0], 1e-3 * free.of_rendering[0]);
  EXPECT_LT(held.of_photos[0], 1e-3 * free.of_photos[0]);
  EXPECT_NEAR(held.of_beliefs[0], 0.01, 1e-4);
}

/// Model of scalars 0 and 1 by rows `a` and `b` of the halves' Jacobians.
QuadraticModel ModelOfRows(const std::vector<std::array<double, 2>>& a,
                           const std::vector<std::array<double, 2>>& b) {
  QuadraticModel model(2);
  for (std::size_t row = 0; row < a.size(); ++row) {
    for (std::size_t p = 0; p < 2; ++p) {
      for (std::size_t q = 0; q < 2; ++q) {
        const double mean = 0.25 * (a[row][p] + b[row][p]) * (a[row][q] + b[row][q]);
        const double difference = 0.25 * (a[row][p] - b[row][p]) * (a[row][q] - b[row][q]);
        model.product[2 * p + q] += mean - difference;
        model.square[2 * p + q] += mean;
        model.scatter[2 * p + q] += 0.01 * mean;  // residuals of 0.1
      }
      const double mixed = 0.25 * (a[row][p] + b[row][p]) * (a[row][p] - b[row][p]);
      model.variance[p] += 4.0 * mixed * mixed;
    }
  }
  model.weight = 1.0;
  return model;
}

TEST_F(QuadraticModelTest, ErrorsOfWhatNoRowTellsAreThoseOfTheBounds) {
  const std::vector<double> none(4, 0.0);
  const double uniform = 1.0 / std::sqrt(12.0);
  // Nothing depends on the second scalar.
  std::vector<std::array<double, 2>> rows(100, {1.0, 0.0});
  optim::StandardErrors errors =
      optim::EstimateErrors(ModelOfRows(rows, rows), none, none, {kOpen, 3.0});
  EXPECT_NEAR(errors.of_photos[0], 0.01, 1e-9);
  EXPECT_EQ(errors.of_ranges[0], 0.0);
  EXPECT_NEAR(errors.of_ranges[1], 3.0 * uniform, 1e-12);
  EXPECT_FALSE(errors.is_hidden);
  // Only their sum is told: both lie anywhere between the bounds of the second one.
  rows.assign(100, {1.0, 1.0});
  errors = optim::EstimateErrors(ModelOfRows(rows, rows), none, none, {kOpen, 3.0});
  EXPECT_NEAR(errors.of_ranges[0], 3.0 * uniform, 1e-6);
  EXPECT_NEAR(errors.of_ranges[1], 3.0 * uniform, 1e-6);
  EXPECT_EQ(optim::EstimateErrors(ModelOfRows(rows, rows), none, none, {kOpen, kOpen}).of_ranges[0],
            kOpen);
  // A prior of the second one is enough for both.
  errors = optim::EstimateErrors(
      ModelOfRows(rows, rows), {0.0, 0.0, 0.0, 100.0}, {0.0, 0.0, 0.0, 1.0}, {kOpen, 3.0});
  EXPECT_EQ(errors.of_ranges[0], 0.0);
  EXPECT_NEAR(errors.of_beliefs[0], 0.01, 1e-6);
}

TEST_F(QuadraticModelTest, ErrorsClaimNothingThatNoiseOfTheJacobianHides) {
  std::mt19937_64 rng(7);
  std::normal_distribution<double> normal;
  const std::vector<double> none(4, 0.0);
  int hidden = 0, seen = 0;
  constexpr int kRepeats = 200;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    for (const double slope : {0.0, 0.5}) {
      std::vector<std::array<double, 2>> a, b;
      for (int row = 0; row < 400; ++row) {
        const double mean = row % 2 == 0 ? slope : -slope;
        a.push_back({1.0, mean + normal(rng)});
        b.push_back({1.0, mean + normal(rng)});
      }
      const optim::StandardErrors errors =
          optim::EstimateErrors(ModelOfRows(a, b), none, none, {kOpen, 3.0});
      (slope > 0.0 ? seen : hidden) += errors.of_ranges[1] == 0.0 ? 1 : 0;
      EXPECT_EQ(errors.is_hidden, errors.of_ranges[1] > 0.0);
    }
  }
  EXPECT_LT(hidden, 0.1 * kRepeats) << "chance of two standard deviations";
  EXPECT_GT(seen, 0.9 * kRepeats);
}

TEST_F(QuadraticModelTest, TheWholeStepIsNotDampedAndLeavesWhatIsNotFreeOrNotTold) {
  const std::vector<double> none(4, 0.0);
  std::vector<std::array<double, 2>> rows(100, {1.0, 0.0});
  for (std::size_t i = 0; i < rows.size(); i += 2) {
    rows[i] = {0.5, 2.0};
  }
  QuadraticModel model = ModelOfRows(rows, rows);
  for (std::size_t i = 0; i < 2; ++i) {  // the minimum is at (3, 4)
    model.linear[i] = 3.0 * model.product[2 * i] + 4.0 * model.product[2 * i + 1];
  }
  std::vector<double> step =
      optim::FindMinimum(model, {1.0, 1.0}, none, {0.0, 0.0}, {true, true}).step;
  EXPECT_NEAR(step[0], 2.0, 1e-6);
  EXPECT_NEAR(step[1], 3.0, 1e-6);
  // Whatever the error of the gradient is, which shortens the step of a round.
  const double gradient = optim::MakeModelAtPoint(model, {1.0, 1.0}, {false, false}).gradient[0];
  model.covariance = {
      std::pow(20.0 * model.product[0], 2), 0.0, 0.0, std::pow(30.0 * model.product[3], 2)};
  EXPECT_LT(optim::MakeModelAtPoint(model, {1.0, 1.0}, {false, false}).gradient[0] / gradient, 0.5);
  EXPECT_EQ(optim::FindMinimum(model, {1.0, 1.0}, none, {0.0, 0.0}, {true, true}).step, step);
  const auto& h = model.product;
  const double whole = 0.5 * (4.0 * h[0] + 6.0 * (h[1] + h[2]) + 9.0 * h[3]) / model.weight;
  EXPECT_NEAR(optim::FindMinimum(model, {1.0, 1.0}, none, {0.0, 0.0}, {true, true}).decrease,
              whole,
              1e-6 * whole);
  EXPECT_NEAR(optim::FindMinimum(model, {3.0, 4.0}, none, {0.0, 0.0}, {true, true}).decrease,
              0.0,
              1e-9 * whole);
  step = optim::FindMinimum(model, {1.0, 4.0}, none, {0.0, 0.0}, {true, false}).step;
  EXPECT_NEAR(step[0], 2.0, 1e-6);
  EXPECT_EQ(step[1], 0.0);
  // A prior of the photos' weight around 1 halves the way of the other scalar.
  step = optim::FindMinimum(
             model, {1.0, 4.0}, {model.product[0], 0.0, 0.0, 0.0}, {0.0, 0.0}, {true, false})
             .step;
  EXPECT_NEAR(step[0], 1.0, 1e-6);
  rows.assign(100, {1.0, 0.0});
  model = ModelOfRows(rows, rows);
  model.linear = {3.0 * model.product[0], 0.0};
  step = optim::FindMinimum(model, {1.0, 1.0}, none, {0.0, 0.0}, {true, true}).step;
  EXPECT_NEAR(step[0], 2.0, 1e-6);
  EXPECT_EQ(step[1], 0.0);
}

TEST_F(QuadraticModelTest, AWeakPriorDoesNotTurnTheGradientOfWhatIsNotToldIntoAStep) {
  // Rows of the second scalar are noise of the halves that cancels.
  std::vector<std::array<double, 2>> a(100, {1.0, 0.0}), b = a;
  for (std::size_t i = 0; i < 10; ++i) {
    a[i] = {0.0, 1.0};
    b[i] = {0.0, i % 2 == 0 ? 2.0 : -2.0};
  }
  QuadraticModel model = ModelOfRows(a, b);
  model.linear = {3.0 * model.product[0], 5.0};
  const double weak = 1e-3 * model.square[3] / model.weight;
  optim::ToMinimum to =
      optim::FindMinimum(model, {1.0, 1.0}, {0.0, 0.0, 0.0, weak}, {0.0, 0.0}, {true, true});
  EXPECT_NEAR(to.step[0], 2.0, 1e-6);
  EXPECT_NEAR(to.step[1], 0.0, 1e-6);
  EXPECT_NEAR(to.decrease, 2.0 * model.product[0] / model.weight, 1e-6 * model.product[0]);
  // Nor does the prior take back what rounds may have found there.
  to = optim::FindMinimum(
      model, {1.0, 1.0}, {0.0, 0.0, 0.0, weak}, {0.0, -2.0 * weak}, {true, true});
  EXPECT_NEAR(to.step[1], 0.0, 1e-6);
}

TEST_F(QuadraticModelTest, LogarithmsWhoseCurvatureIsNotToldHardlyMove) {
  // Rows of the second scalar are noise of the halves that agrees by chance.
  std::vector<std::array<double, 2>> a(100, {1.0, 0.0}), b = a;
  for (std::size_t i = 0; i < 10; ++i) {
    a[i] = {0.0, 1.0};
    b[i] = {0.0, i < 6 ? 2.0 : -2.6};
  }
  QuadraticModel model = ModelOfRows(a, b);
  model.covariance = {1e-9, 0.0, 0.0, 1e-9};
  model.linear = {5.0 * model.product[0], 5.0 * model.product[3]};
  const auto gradient = [&](bool is_log) {
    return optim::MakeModelAtPoint(model, {0.0, 0.0}, {is_log, is_log}).gradient;
  };
  EXPECT_NEAR(gradient(true)[0] / gradient(false)[0], 1.0, 0.02) << "told";
  EXPECT_LT(gradient(true)[1] / gradient(false)[1], 0.5);
  EXPECT_GT(gradient(true)[1] / gradient(false)[1], 0.0);
}

TEST_F(QuadraticModelTest, StepsWithinTheirErrorAreKnown) {
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.2);
  const QuadraticModel model = Linearized(source, start_, 0).model();
  const double by_chance = optim::LargestStepByChance(start_.size());
  EXPECT_EQ(optim::SignificanceOfStep(std::vector<double>(start_.size(), 0.0), model), 0.0);
  EXPECT_GT(optim::SignificanceOfStep(std::vector<double>(start_.size(), 1.0), model), by_chance);
  const std::vector<double> truth = set_.ThetaFromValues(fit_.truth);
  ImageProblem there = Linearized(source, truth, 1);
  std::vector<double> step = Solve(there, truth).theta;
  for (std::size_t i = 0; i < step.size(); ++i) {
    step[i] -= truth[i];
  }
  EXPECT_LT(optim::SignificanceOfStep(step, there.model()), by_chance);
}

/// Images of which nothing is seen for noise once they are away from `clear`.
class BlindingImageSource : public LinearImageSource {
 public:
  using LinearImageSource::LinearImageSource;
  void SetValues(const std::vector<double>& values) override {
    LinearImageSource::SetValues(values);
    is_clear_ = clear.empty() || values == clear;
  }
  [[nodiscard]] renderer::Film RenderPrimal(int view,
                                            const optim::SampleSet& samples) const override {
    renderer::Film film = LinearImageSource::RenderPrimal(view, samples);
    for (std::size_t p = 0; p < film.pixels.size() && !is_clear_; ++p) {
      renderer::CounterRng noise(samples.seed, renderer::RandomDomain{3}, 0, p, 0);
      film.pixels[p].g += 1e4 * (noise.Next() - 0.5);
    }
    return film;
  }
  std::vector<double> clear;

 private:
  bool is_clear_ = true;
};

TEST_F(QuadraticModelTest, TrialsThatNoiseDrownsAreNotTaken) {
  BlindingImageSource source(32, 16, tests::kNumBlocks, 4, 0.05);
  ImageProblem problem = Linearized(source, start_, 0);
  const double before = problem.costs().Total();
  std::vector<double> halfway = fit_.truth;
  for (std::size_t i = 0; i < halfway.size(); ++i) {
    halfway[i] = 0.5 * (halfway[i] + start_[i]);
  }
  problem.EvalTrial(halfway);
  EXPECT_LT(problem.costs().Total(), before);
  source.clear = start_;
  problem.EvalTrial(halfway);
  EXPECT_GT(problem.costs().Total(), before);
}

TEST_F(QuadraticModelTest, RoundsFromAfarAreForgotten) {
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.2);
  optim::RoundSums rounds = Linearized(source, start_, 0).TakeRounds();
  const double before = rounds.model.weight;
  rounds.Forget(std::vector<double>(start_.size(), 0.0));
  EXPECT_EQ(rounds.model.weight, before);
  rounds.Forget(std::vector<double>(start_.size(), 1.0));
  EXPECT_LT(rounds.model.weight, 0.05 * before);
  EXPECT_GT(rounds.model.weight, 0.0);
  EXPECT_EQ(rounds.rows.weight, rounds.model.weight);
}

TEST_F(QuadraticModelTest, AThingWithoutAnyEffectHasNoModelAndNoStep) {
  const std::size_t n = 3;
  QuadraticModel round(n);
  round.FinishRound({1.0, 2.0, 3.0}, {0.0, 0.0, 0.0});
  QuadraticModel model;
  EXPECT_EQ(optim::ShareAgreed(round, {1.0, 2.0, 3.0}, model), 1.0);
  optim::AddRound(round, 1.0, model);
  EXPECT_EQ(optim::ShareAgreed(round, {1.0, 2.0, 3.0}, model), 1.0);
  optim::AddRound(round, 1.0, model);
  EXPECT_EQ(optim::ShareThatHolds({1.0, 1.0, 1.0}, model), 1.0);
  const std::vector<bool> logs(n, true);
  for (const double g : optim::MakeModelAtPoint(model, {1.0, 2.0, 3.0}, logs).gradient) {
    EXPECT_EQ(g, 0.0);
  }
}

/// A full step by the logarithm overshoots a hundredfold where the start is a sixth of the truth.
TEST_F(QuadraticModelTest, LogarithmsThatStartMuchTooDarkArrive) {
  fit_.unknowns[0].parameterization = optim::Parameterization::kLog;
  set_ = optim::ParameterSet(fit_.scene, fit_.unknowns, {0}, {}, {});
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.0);
  std::vector<double> dark = fit_.truth;
  for (double& x : dark) {
    x /= 6.4;
  }
  std::vector<double> theta = set_.ThetaFromValues(dark);
  for (std::uint64_t r = 0; r < 12; ++r) {
    ImageProblem problem = Linearized(source, theta, r);
    theta = Solve(problem, theta).theta;
  }
  EXPECT_LT(Error(theta), 1e-3);
}

}  // namespace
}  // namespace pathfit::quadratic_model_test
