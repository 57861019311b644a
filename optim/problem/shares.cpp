#include "optim/problem/shares.h"

#include <utility>

namespace pathfit::optim {

// Here alone: Eigen's solvers take half a minute to compile for the sanitizers.
std::optional<Shares> SharesOf(const Eigen::MatrixXd& part, const Eigen::MatrixXd& whole) {
  Shares shares(part, whole);
  if (shares.info() != Eigen::Success || !shares.eigenvalues().allFinite()) return std::nullopt;
  return std::optional(std::move(shares));
}

Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> DirectionsOf(const Eigen::MatrixXd& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix);
}

}  // namespace pathfit::optim
