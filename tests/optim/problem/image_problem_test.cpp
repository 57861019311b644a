#include "optim/problem/image_problem.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "tests/optim/problem/linear_rounds.h"

namespace pathfit::image_problem_test {
namespace {

using optim::ImageProblem;
using optim::ImageProblemOptions;
using optim::LinearSolverChoice;
using optim::ParameterSet;
using tests::LinearImageSource;

class ImageProblemTest : public tests::LinearRounds {
 protected:
  static ImageProblemOptions Options(LinearSolverChoice choice, std::uint64_t seed) {
    ImageProblemOptions options = OptionsOf(seed);
    options.linear_solver = choice;
    return options;
  }
};

TEST_F(ImageProblemTest, GradientIsTheDifferenceQuotientOfTheCost) {
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.3);
  std::vector<double> x(fit_.truth.size(), 1.0);
  const ImageProblemOptions options = Options(LinearSolverChoice::kCholesky, 5);
  ImageProblem problem(source, fit_.views, set_, options);
  problem.Linearize(x);
  const std::vector<double> gradient = problem.sums().gradient;
  for (const std::size_t i : {std::size_t{0}, std::size_t{17}, std::size_t{100}}) {
    constexpr double kStep =
        1e-3;  // the cost is quadratic: central differences are exact up to float Jacobians
    x[i] = 1.0 + kStep;
    problem.EvalTrial(x);
    const double above = problem.costs().Total();
    x[i] = 1.0 - kStep;
    problem.EvalTrial(x);
    const double below = problem.costs().Total();
    x[i] = 1.0;
    EXPECT_NEAR(gradient[i], (above - below) / (2.0 * kStep), 1e-5 * std::abs(gradient[i]) + 1e-6);
  }
}

TEST_F(ImageProblemTest, NormalEquationsAreTheSameForAnyNumberOfThreads) {
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.5);
  std::vector<std::vector<double>> matrices;
  for (const int threads : {1, 2}) {
    const renderer::ThreadLimit limit(threads);
    ImageProblem problem(source, fit_.views, set_, Options(LinearSolverChoice::kGram, 1));
    problem.Linearize(fit_.truth);
    matrices.push_back(problem.gram().upper);
  }
  EXPECT_EQ(matrices[0], matrices[1]);
}

TEST_F(ImageProblemTest, RefusesBeforeTheMemoryIsTakenAndSaysWhatHelps) {
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.0);
  for (const auto choice : {LinearSolverChoice::kGram, LinearSolverChoice::kCgnr}) {
    ImageProblemOptions options = Options(choice, 1);
    options.max_memory_bytes = 1e4;
    ImageProblem problem(source, fit_.views, set_, options);
    try {
      problem.Linearize(fit_.truth);
      FAIL() << "not refused";
    } catch (const optim::MemoryError& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find("limit"), std::string::npos) << text;
      EXPECT_NE(text.find("image_scale"), std::string::npos) << text;
    }
  }
}

TEST_F(ImageProblemTest, NamesViewPixelAndParameterOfANumberThatIsNotFinite) {
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.0);
  source.broken_derivative = 35;
  ImageProblem problem(source, fit_.views, set_, Options(LinearSolverChoice::kCgnr, 1));
  try {
    problem.Linearize(fit_.truth);
    FAIL() << "not found";
  } catch (const renderer::NumericalError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("'photo0', pixel (3, 1)"), std::string::npos) << text;
    EXPECT_NE(text.find("ball.vertices["), std::string::npos) << text;
  }
  source.broken_derivative = -1;
  source.broken_pixel = 33;
  ImageProblem other(source, fit_.views, set_, Options(LinearSolverChoice::kCgnr, 1));
  EXPECT_THROW(other.Linearize(fit_.truth), renderer::NumericalError);
}

TEST_F(ImageProblemTest, RefusesSumsThatOverflow) {
  // An environment of 1e30 passed every check and left a negative rest in the normal equations.
  fit_.unknowns[0].parameterization = optim::Parameterization::kLog;
  set_ = ParameterSet(fit_.scene, fit_.unknowns, {0}, {}, {});
  LinearImageSource source(32, 16, tests::kNumBlocks, 4, 0.3);
  const std::vector<double> huge(fit_.truth.size(), 1e30);
  for (const LinearSolverChoice choice : {LinearSolverChoice::kGram, LinearSolverChoice::kCgnr}) {
    ImageProblem problem(source, fit_.views, set_, Options(choice, 1));
    EXPECT_THROW(problem.Linearize(huge), renderer::NumericalError);
  }
  const std::vector<double> hessian(4);
  EXPECT_THROW(optim::MakeGramRoot(hessian, {0.0, 0.0}, 1e308, 1e305), renderer::NumericalError);
  EXPECT_NO_THROW(optim::MakeGramRoot(hessian, {0.0, 0.0}, 1e3, 1e3));
}

TEST_F(ImageProblemTest, CensorsClippedChannelsThatAreNotSurelyRenderedDarker) {
  optim::ViewLevel level = fit_.views.levels[0].Unpack();
  level.clipped = renderer::Image(32, 16, 1);
  level.clipped.data[5] = level.clipped.data[7] = 1.0F;
  for (const std::size_t p : {5, 7}) {
    for (std::size_t c = 0; c < 3; ++c) level.photo.data[3 * p + c] = c == 2 ? 0.2F : 1.0F;
  }
  renderer::Film a(32, 16), b(32, 16);
  a.pixels[5] = b.pixels[5] = {100.0, -100.0, 100.0, 1.0};
  a.pixels[6] = b.pixels[6] = {100.0, 100.0, 100.0, 1.0};
  // Darker in the mean: by less and by more than what the halves differ by tells.
  a.pixels[7] = {1.05, 0.9, 0.2, 1.0};
  b.pixels[7] = {0.85, 0.89, 0.2, 1.0};
  const optim::RowScales scales =
      optim::MakeRowScales(level, false, {}, optim::JudgePixels(level, {}, a, b));
  EXPECT_EQ(scales[5][0], 0.0F);
  EXPECT_EQ(scales[5][1], 1.0F);
  EXPECT_EQ(scales[5][2], 1.0F) << "a channel that is not clipped";
  EXPECT_EQ(scales[6][0], 1.0F);
  EXPECT_EQ(scales[7][0], 0.0F);
  EXPECT_EQ(scales[7][1], 1.0F);
}

TEST_F(ImageProblemTest, RobustLossCountsLargeResidualsByTheirSize) {
  optim::ViewLevel level = fit_.views.levels[0].Unpack();
  level.clipped = renderer::Image(32, 16, 1);
  level.clipped.data[8] = 1.0F;
  level.photo.data[3 * 8] = 1.0F;
  const auto photo = [&](std::size_t p) {
    return renderer::Rgba(
        level.photo.data[3 * p], level.photo.data[3 * p + 1], level.photo.data[3 * p + 2], 1.0);
  };
  renderer::Film film(32, 16);
  for (std::size_t p = 0; p < film.pixels.size(); ++p) film.pixels[p] = photo(p);
  film.pixels[5] += renderer::Rgba(0.4, -0.4, 0.4, 0.0);
  film.pixels[6] += renderer::Rgba(0.09, 0.09, 0.09, 0.0);
  film.pixels[7] += renderer::Rgba(1e9, 0.0, 0.0, 0.0);
  film.pixels[8] += renderer::Rgba(0.4, 0.0, 0.0, 0.0);  // "at least this": no residual at all
  optim::LossSpec loss;
  loss.robust_huber = 0.1;
  const optim::RowScales scales =
      optim::MakeRowScales(level, false, loss, optim::JudgePixels(level, loss, film, film));
  EXPECT_NEAR(scales[5][0], std::sqrt(0.1 / 0.4), 1.0 / 255.0);
  EXPECT_EQ(scales[5][0], scales[5][2]);
  EXPECT_EQ(scales[6][0], 1.0F);
  EXPECT_GT(scales[7][0], 0.0F);
  EXPECT_LT(scales[7][0], 0.01F);
  EXPECT_EQ(scales[8][0], 0.0F);
  EXPECT_EQ(scales[8][1], 1.0F);
}

}  // namespace
}  // namespace pathfit::image_problem_test
