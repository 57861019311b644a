#include "optim/solver/linear_solver_policy.h"

#include <algorithm>

namespace pathfit::optim {
namespace {

// Measured on meshes of 2.5, 10 and 40 thousand vertices; beyond these Cholesky's factor or
// products cost more than conjugate gradients' iterations.
constexpr double kAlwaysSmallScalars = 9000.0;
constexpr double kLocalScalars = 120000.0;
constexpr double kLocalBlocksPerGroup = 20.0;
constexpr double kMaxProductFlops = 4e10;

}  // namespace

LinearSolverKind ChooseLinearSolver(LinearSolverChoice choice,
                                    const ProblemSize& size,
                                    double max_bytes) {
  if (choice == LinearSolverChoice::kCholesky) {
    CheckFits(size, LinearSolverKind::kCholesky, max_bytes);
    return LinearSolverKind::kCholesky;
  }
  const double blocks_per_group = size.group_blocks / std::max(1.0, size.num_groups);
  const bool is_small = size.num_scalars <= kAlwaysSmallScalars;
  const bool is_local =
      size.num_scalars <= kLocalScalars && blocks_per_group <= kLocalBlocksPerGroup;
  if (choice == LinearSolverChoice::kAuto && (is_small || is_local) &&
      size.product_flops <= kMaxProductFlops &&
      Fits(size, LinearSolverKind::kCholesky, max_bytes)) {
    return LinearSolverKind::kCholesky;
  }
  CheckFits(size, LinearSolverKind::kCgnr, max_bytes);
  return LinearSolverKind::kCgnr;
}

}  // namespace pathfit::optim
