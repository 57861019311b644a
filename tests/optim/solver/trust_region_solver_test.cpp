#include "optim/solver/trust_region_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "tests/optim/problem/linear_image_source.h"

namespace pathfit::trust_region_solver_test {
namespace {

using optim::ImageProblem;
using optim::LinearSolverChoice;
using optim::LinearSolverKind;
using optim::ProblemSize;
using optim::SolveOptions;
using optim::SolveOutcome;
using tests::LinearFit;
using tests::LinearImageSource;

// As measured on icospheres: panels of 13 rows and 17 blocks.
ProblemSize Sized(double num_scalars, double num_panels) {
  constexpr double kBlocks = 17.0;
  ProblemSize size;
  size.num_scalars = num_scalars;
  size.roots.num_panels = num_panels;
  size.roots.panel_blocks = num_panels * kBlocks;
  size.roots.jacobian_cells = 14.0 * num_panels * 3.0 * kBlocks;
  size.roots.kept_bytes = 4.0 * size.roots.jacobian_cells;
  size.roots.product_cells = 0.5 * num_panels * kBlocks * (kBlocks + 1.0);
  return size;
}

TEST(SolverOfRows, RefusesWhatDoesNotFit) {
  const auto solver = [](LinearSolverChoice choice, double num_panels, double max_bytes) {
    return optim::SolverOfRows(choice, Sized(120e3, num_panels), max_bytes);
  };
  EXPECT_EQ(solver(LinearSolverChoice::kCgnr, 150e3, 3e9), LinearSolverKind::kCgnr);
  EXPECT_EQ(solver(LinearSolverChoice::kCholesky, 150e3, 0.0), LinearSolverKind::kCholesky);
  EXPECT_THROW(solver(LinearSolverChoice::kCgnr, 150e3, 1e9), optim::MemoryError);
  EXPECT_THROW(solver(LinearSolverChoice::kCholesky, 150e3, 3e9), optim::MemoryError);
  EXPECT_THROW(solver(LinearSolverChoice::kCgnr, 4e6, 0.0), optim::MemoryError);  // 2^31 cells
}

class TrustRegionSolverTest : public testing::Test {
 protected:
  SolveOutcome Step(LinearSolverChoice choice, LinearSolverKind kind, double noise) {
    LinearImageSource source(48, 32, tests::kNumBlocks, 4, noise);
    optim::ImageProblemOptions options;
    options.linear_solver = choice;
    options.samples = {{{.spp = 1}, 1}, {{.spp = 1}, 2}};
    ImageProblem problem(source, fit_.views, set_, options);
    problem.Linearize(start_);
    SolveOptions solve;
    solve.linear_solver = kind;
    solve.radius = radius_;
    solve.shared_radius_factor = shared_radius_factor_;
    solve.step_share = step_share_;
    solve.eta = 1e-8;
    solve.restrain = restrain_;
    const SolveOutcome outcome = optim::SolveRound(problem, priors_, {}, start_, solve);
    cost_after_ = problem.costs().Total();
    return outcome;
  }

  static double Distance(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      sum += (a[i] - b[i]) * (a[i] - b[i]);
    }
    return std::sqrt(sum);
  }

  LinearFit fit_ = tests::MakeLinearFit(48, 32, 3, 4);
  optim::ParameterSet set_{fit_.scene, fit_.unknowns, {0}, {}, {}};
  std::vector<double> start_ = std::vector<double>(fit_.truth.size(), 1.0);
  std::vector<optim::PriorTerm> priors_;
  std::function<bool(std::vector<double>&)> restrain_;
  double radius_ = 10.0, shared_radius_factor_ = 1.0, step_share_ = 1.0;
  double cost_after_ = 0.0;
};

TEST_F(TrustRegionSolverTest, AllLinearSolversTakeTheSameStep) {
  for (std::int32_t b = 0; b < tests::kNumBlocks; ++b) {
    priors_.push_back({{b}, {0.3}, {0.2, 0.3, 0.4}, false, false});
  }
  for (const double noise : {0.0, 0.3}) {
    const SolveOutcome gram = Step(LinearSolverChoice::kGram, LinearSolverKind::kGram, noise);
    const SolveOutcome cholesky =
        Step(LinearSolverChoice::kCholesky, LinearSolverKind::kCholesky, noise);
    const SolveOutcome cgnr = Step(LinearSolverChoice::kCgnr, LinearSolverKind::kCgnr, noise);
    ASSERT_TRUE(gram.accepted && cholesky.accepted && cgnr.accepted);
    const double length = Distance(gram.theta, start_);
    // The dense form takes the noise of J out of J^T J, so that its step is longer.
    if (noise == 0.0) {
      EXPECT_LT(Distance(gram.theta, cholesky.theta), 1e-6 * length);
    }
    EXPECT_LT(Distance(cgnr.theta, cholesky.theta), 1e-4 * length);
  }
}

TEST_F(TrustRegionSolverTest, SparseNormalEquationsTakeTheStepOfTheRows) {
  for (std::int32_t b = 0; b < tests::kNumBlocks; ++b) {
    priors_.push_back(
        {{b, (b + 1) % tests::kNumBlocks}, {0.3, -0.3}, {0.2, 0.3, 0.4}, false, false});
    priors_.push_back({.blocks = {b}, .weights = {0.3}, .offset = {0.2, 0.3, 0.4}, .edge = 0.05});
  }
  // Of rows without noise: roots are rid of it, sparse normal equations are not.
  SolveOutcome rows, sparse;
  const auto step = [&] {
    rows = Step(LinearSolverChoice::kCgnr, LinearSolverKind::kCgnr, 0.0);
    sparse = Step(LinearSolverChoice::kSparseGram, LinearSolverKind::kSparseGram, 0.0);
    ASSERT_TRUE(rows.accepted && sparse.accepted);
    EXPECT_LT(Distance(sparse.theta, rows.theta), 1e-4 * Distance(rows.theta, start_));
    EXPECT_EQ(sparse.trials, rows.trials);
  };
  step();
  EXPECT_NEAR(sparse.relative_decrease, rows.relative_decrease, 1e-3);
  fit_.unknowns[0].upper = 1.2;
  set_ = optim::ParameterSet(fit_.scene, fit_.unknowns, {0}, {}, {});
  step();
  EXPECT_LE(*std::ranges::max_element(sparse.theta), 1.2);
  EXPECT_NEAR(sparse.relative_decrease, 1.0, 1e-3) << "of the way within the bounds";
}

// The last four vertices as a mesh of its own.
TEST_F(TrustRegionSolverTest, UnknownsOfSmallGroupsHaveARadiusOfTheirOwn) {
  renderer::SceneMesh& ball = fit_.scene.meshes[0];
  const std::vector<renderer::Vec3> places(ball.mesh.positions.begin(), ball.mesh.positions.end());
  renderer::SceneMesh small = ball;
  ball.mesh.positions = std::vector<renderer::Vec3>(places.begin(), places.end() - 4);
  ball.mesh.triangles = std::vector<std::array<int, 3>>{{0, 1, 2}};
  small.mesh.positions = std::vector<renderer::Vec3>(places.end() - 4, places.end());
  small.mesh.triangles = std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}};
  small.name = "small";
  fit_.scene.meshes.push_back(small);
  fit_.unknowns.push_back(fit_.unknowns[0]);
  fit_.unknowns[1].name = "small.vertices";
  fit_.unknowns[1].object = 1;
  set_ = optim::ParameterSet(fit_.scene, fit_.unknowns, {0, 1}, {}, {});
  const auto step = [&] {
    std::vector<double> theta =
        Step(LinearSolverChoice::kSparseGram, LinearSolverKind::kSparseGram, 0.0).theta;
    for (std::size_t i = 0; i < theta.size(); ++i) theta[i] -= start_[i];
    return theta;
  };
  const auto square = [](auto first, auto end) {
    return std::inner_product(first, end, first, 0.0);
  };
  radius_ = 1e-2;
  const std::vector<double> damped = step();
  shared_radius_factor_ = 1e6;
  const std::vector<double> own = step();
  ASSERT_EQ(own.size(), 3U * 42);
  EXPECT_GT(square(own.end() - 12, own.end()), 1e3 * square(damped.end() - 12, damped.end()));
  EXPECT_LT(square(own.begin(), own.end() - 12), 2.0 * square(damped.begin(), damped.end() - 12));
}

TEST_F(TrustRegionSolverTest, SparseStepsAreJudgedByTheWayThatWasTaken) {
  const auto step = [this] {
    return Step(LinearSolverChoice::kSparseGram, LinearSolverKind::kSparseGram, 0.0);
  };
  const SolveOutcome free = step();
  // Half of the vertices stay: the photos are linear, and the model says what the rest gains.
  restrain_ = [this](std::vector<double>& values) {
    std::copy_n(start_.begin(), start_.size() / 2, values.begin());
    return true;
  };
  const SolveOutcome held = step();
  ASSERT_TRUE(free.accepted && held.accepted);
  EXPECT_EQ(held.theta.front(), start_.front());
  EXPECT_NE(held.theta.back(), start_.back());
  EXPECT_NEAR(free.relative_decrease, 1.0, 1e-6);
  EXPECT_NEAR(held.relative_decrease, 1.0, 1e-6);
  EXPECT_EQ(held.trials, 1);
}

TEST_F(TrustRegionSolverTest, SparseStepsAreTakenAsFarAsTheCostFalls) {
  radius_ = 1e6;
  const auto step = [this] {
    return Step(LinearSolverChoice::kSparseGram, LinearSolverKind::kSparseGram, 0.0);
  };
  const SolveOutcome whole = step();
  ASSERT_TRUE(whole.accepted);
  EXPECT_EQ(whole.step_share, 1.0);
  // Four times as far as the model wants, so that a quarter of it is best.
  restrain_ = [this](std::vector<double>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = start_[i] + 4.0 * (values[i] - start_[i]);
    }
    return true;
  };
  const SolveOutcome quarter = step();
  ASSERT_TRUE(quarter.accepted);
  EXPECT_EQ(quarter.trials, 1) << "with the same radius";
  EXPECT_NEAR(quarter.step_share, 0.25, 1e-3);
  EXPECT_LT(Distance(quarter.theta, whole.theta), 1e-3 * Distance(whole.theta, start_));
  EXPECT_LT(cost_after_, 1e-6) << "the problem knows what was accepted";
  // The next round begins with that, and finds back to the whole step where it is right.
  step_share_ = quarter.step_share;
  EXPECT_NEAR(step().step_share, 0.25, 1e-3);
  restrain_ = nullptr;
  const SolveOutcome part = step();
  EXPECT_NEAR(Distance(part.theta, start_), step_share_ * Distance(whole.theta, start_), 1e-3);
  EXPECT_NEAR(part.step_share, 1.0, 1e-3);
}

TEST_F(TrustRegionSolverTest, SparseRoundsStayOrEndAsOthersDo) {
  restrain_ = [](std::vector<double>&) { return false; };
  const SolveOutcome rows = Step(LinearSolverChoice::kCgnr, LinearSolverKind::kCgnr, 0.3);
  const SolveOutcome sparse =
      Step(LinearSolverChoice::kSparseGram, LinearSolverKind::kSparseGram, 0.3);
  EXPECT_FALSE(sparse.accepted);
  EXPECT_EQ(sparse.theta, start_);
  EXPECT_EQ(sparse.trials, rows.trials);
  EXPECT_EQ(sparse.radius, rows.radius);
  restrain_ = [](std::vector<double>&) -> bool { throw renderer::Cancelled(); };
  EXPECT_THROW(Step(LinearSolverChoice::kSparseGram, LinearSolverKind::kSparseGram, 0.3),
               renderer::Cancelled);
  restrain_ = nullptr;
  priors_.push_back({{0}, {std::numeric_limits<double>::infinity()}, {}, false, false});
  EXPECT_THROW(Step(LinearSolverChoice::kSparseGram, LinearSolverKind::kSparseGram, 0.3),
               renderer::NumericalError);
}

TEST_F(TrustRegionSolverTest, OneStepTakesALinearProblemMostOfTheWay) {
  const SolveOutcome outcome =
      Step(LinearSolverChoice::kCholesky, LinearSolverKind::kCholesky, 0.0);
  ASSERT_TRUE(outcome.accepted);
  EXPECT_EQ(outcome.trials, 1);
  EXPECT_LT(Distance(outcome.theta, fit_.truth), 0.2 * Distance(start_, fit_.truth));
}

TEST_F(TrustRegionSolverTest, IsTheSameToTheLastBitWhenRepeated) {
  const SolveOutcome first = Step(LinearSolverChoice::kCholesky, LinearSolverKind::kCholesky, 0.3);
  const SolveOutcome second = Step(LinearSolverChoice::kCholesky, LinearSolverKind::kCholesky, 0.3);
  EXPECT_EQ(first.theta, second.theta);
}

TEST_F(TrustRegionSolverTest, StaysWhereItIsIfNoTrialIsAdmitted) {
  restrain_ = [](std::vector<double>&) { return false; };
  const SolveOutcome outcome = Step(LinearSolverChoice::kGram, LinearSolverKind::kGram, 0.3);
  EXPECT_FALSE(outcome.accepted);
  EXPECT_EQ(outcome.theta, start_);
  EXPECT_GT(outcome.trials, 1);
}

TEST_F(TrustRegionSolverTest, AcceptsTheTrialAsItWasRestrained) {
  restrain_ = [this](std::vector<double>& values) {
    values[1] = start_[1];
    return true;
  };
  const SolveOutcome outcome =
      Step(LinearSolverChoice::kCholesky, LinearSolverKind::kCholesky, 0.3);
  ASSERT_TRUE(outcome.accepted);
  EXPECT_EQ(outcome.theta[1], start_[1]);
  EXPECT_NE(outcome.theta[0], start_[0]);
}

TEST_F(TrustRegionSolverTest, BringsErrorsOfTrialsOutOfTheSolver) {
  int calls = 0;
  restrain_ = [&calls](std::vector<double>&) -> bool {
    ++calls;
    PATHFIT_CHECK(calls < 0);
    return true;
  };
  for (const LinearSolverKind kind : {LinearSolverKind::kCholesky, LinearSolverKind::kCgnr}) {
    calls = 0;
    const auto choice =
        kind == LinearSolverKind::kCgnr ? LinearSolverChoice::kCgnr : LinearSolverChoice::kCholesky;
    EXPECT_THROW(Step(choice, kind, 0.3), renderer::InternalError);
    EXPECT_EQ(calls, 1);
  }
  restrain_ = [](std::vector<double>&) -> bool { throw renderer::Cancelled(); };
  EXPECT_THROW(Step(LinearSolverChoice::kGram, LinearSolverKind::kGram, 0.3), renderer::Cancelled);
  restrain_ = [](std::vector<double>&) -> bool { throw renderer::SceneError("folded"); };
  EXPECT_FALSE(Step(LinearSolverChoice::kGram, LinearSolverKind::kGram, 0.3).accepted);
}

TEST_F(TrustRegionSolverTest, SaysInTheSolversWordsWhyItGaveUp) {
  restrain_ = [](std::vector<double>&) { return false; };
  SolveOutcome outcome = Step(LinearSolverChoice::kGram, LinearSolverKind::kGram, 0.3);
  EXPECT_FALSE(outcome.accepted);
  EXPECT_EQ(outcome.failure, "");  // rejected trials are a usual round
  restrain_ = nullptr;
  priors_.push_back({{0}, {std::numeric_limits<double>::infinity()}, {}, false, false});
  try {
    Step(LinearSolverChoice::kGram, LinearSolverKind::kGram, 0.3);
    FAIL() << "a start that cannot be evaluated was accepted";
  } catch (const renderer::NumericalError& error) {
    EXPECT_NE(std::string(error.what()).find("evaluation failed"), std::string::npos)
        << error.what();
  }
}

TEST_F(TrustRegionSolverTest, SparseRoundsSayWhyTheyGaveUp) {
  // Holds at the start; its square, which the normal equations need, is beyond all numbers.
  priors_.push_back({.blocks = {0}, .weights = {1e200}, .offset = {1e200, 1e200, 1e200}});
  const SolveOutcome outcome =
      Step(LinearSolverChoice::kSparseGram, LinearSolverKind::kSparseGram, 0.3);
  EXPECT_FALSE(outcome.accepted);
  EXPECT_EQ(outcome.theta, start_);
  EXPECT_EQ(outcome.trials, 0);
  EXPECT_EQ(outcome.failure, "no step lowers the quadratic model");
}

TEST_F(TrustRegionSolverTest, KeepsBounds) {
  fit_.unknowns[0].upper = 1.2;
  set_ = optim::ParameterSet(fit_.scene, fit_.unknowns, {0}, {}, {});
  const SolveOutcome outcome =
      Step(LinearSolverChoice::kCholesky, LinearSolverKind::kCholesky, 0.0);
  double largest = 0.0;
  for (const double x : outcome.theta) {
    largest = std::max(largest, x);
  }
  EXPECT_LE(largest, 1.2);
  EXPECT_GT(largest, 1.19);
}

}  // namespace
}  // namespace pathfit::trust_region_solver_test
