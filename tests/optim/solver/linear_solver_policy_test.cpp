#include "optim/solver/linear_solver_policy.h"

#include <gtest/gtest.h>

namespace pathfit {
namespace {

using optim::ChooseLinearSolver;
using optim::LinearSolverChoice;
using optim::LinearSolverKind;
using optim::ProblemSize;

// The measured table: icospheres of 2.5 and 40 thousand vertices, groups of 13 rows and 17 blocks.
ProblemSize Sized(double num_scalars, double num_groups, double blocks) {
  ProblemSize size;
  size.num_scalars = num_scalars;
  size.num_groups = num_groups;
  size.group_blocks = num_groups * blocks;
  size.num_rows = 13.0 * num_groups;
  size.jacobian_cells = 14.0 * num_groups * 3.0 * blocks;
  size.product_cells = 0.5 * num_groups * blocks * (blocks + 1.0);
  size.product_flops = 14.0 * num_groups * 9.0 * blocks * blocks;
  return size;
}

TEST(LinearSolverPolicy, TakesCholeskyForSmallOrLocalProblems) {
  EXPECT_EQ(ChooseLinearSolver(LinearSolverChoice::kAuto, Sized(7700, 19e3, 17), 0.0),
            LinearSolverKind::kCholesky);
  EXPECT_EQ(ChooseLinearSolver(LinearSolverChoice::kAuto, Sized(7700, 19e3, 45), 0.0),
            LinearSolverKind::kCholesky);
  EXPECT_EQ(ChooseLinearSolver(LinearSolverChoice::kAuto, Sized(120e3, 150e3, 17), 0.0),
            LinearSolverKind::kCholesky);
}

TEST(LinearSolverPolicy, TakesConjugateGradientsWhereTheFactorWouldFillOrNotFit) {
  EXPECT_EQ(ChooseLinearSolver(LinearSolverChoice::kAuto, Sized(30e3, 150e3, 45), 0.0),
            LinearSolverKind::kCgnr);
  EXPECT_EQ(ChooseLinearSolver(LinearSolverChoice::kAuto, Sized(120e3, 150e3, 17), 3e9),
            LinearSolverKind::kCgnr);
}

TEST(LinearSolverPolicy, RefusesWhatFitsNowhere) {
  EXPECT_THROW(ChooseLinearSolver(LinearSolverChoice::kAuto, Sized(120e3, 150e3, 17), 1e9),
               optim::MemoryError);
  EXPECT_THROW(ChooseLinearSolver(LinearSolverChoice::kCholesky, Sized(120e3, 150e3, 17), 3e9),
               optim::MemoryError);
  EXPECT_THROW(ChooseLinearSolver(LinearSolverChoice::kAuto, Sized(120e3, 4e6, 17), 0.0),
               optim::MemoryError);  // 2^31 cells
}

}  // namespace
}  // namespace pathfit
