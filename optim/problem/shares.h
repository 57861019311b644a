#pragma once

#include <optional>

#include <Eigen/Dense>

namespace pathfit::optim {

using Shares = Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>;

/// Of symmetric matrices, `whole` positive: directions X with X^T whole X = 1 in which `part` is
/// diagonal, its eigenvalues the share of it in each. Empty where rounding leaves none.
std::optional<Shares> SharesOf(const Eigen::MatrixXd& part, const Eigen::MatrixXd& whole);

/// Orthonormal directions in which a symmetric matrix is diagonal.
Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> DirectionsOf(const Eigen::MatrixXd& matrix);

}  // namespace pathfit::optim
