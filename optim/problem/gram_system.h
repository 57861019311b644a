#pragma once

#include <cstddef>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/fit_views.h"
#include "optim/problem/pixel_rows.h"

namespace pathfit::optim {

/// First-order sums over all rows by theta, accumulated view by view in a fixed order (any thread
/// count, same bits). With J the mean of the halves' Jacobians and r_a, r_b their residuals:
///   gradient = (J_a^T r_b + J_b^T r_a) / 2 = J^T u - (dv)^T v,   diagonal = diag(J^T J),   hessian
///   = J^T J.
struct GradientSums {
  std::vector<double> gradient, diagonal;
  explicit GradientSums(std::size_t num_scalars = 0)
      : gradient(num_scalars), diagonal(num_scalars) {}

  void Add(const PixelRows& rows, const ParameterSet& set);
  /// Those of other views.
  void Add(const GradientSums& other);
};

/// Square root of the quadratic form: residual and Jacobian with the cost's exact gradient and
/// Gauss-Newton matrix. Twice the cost at the linearisation is |u|^2 - |v|^2 + C^2; C^2 keeps the
/// last residual real.
struct GramRoot {
  std::vector<double> residual;  ///< num_scalars + 1
  std::vector<double> upper;     ///< L^T, row-major num_scalars^2, H + tiny I = L L^T
  double offset_squared = 0.0;   ///< C^2
};
/// `signal_squared`: |u|^2, `noise_squared`: |v|^2, both at the linearisation. Throws
/// renderer::NumericalError if sums overflow.
/// `hessian`: row-major, positive semidefinite.
GramRoot MakeGramRoot(const std::vector<double>& hessian,
                      const std::vector<double>& gradient,
                      double signal_squared,
                      double noise_squared);

}  // namespace pathfit::optim
