#include "optim/problem/gram_system.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "renderer/core/error.h"

namespace pathfit::optim {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kRelativeShift = 1e-10;  // of the mean diagonal: makes the Cholesky root exist

}  // namespace

void GradientSums::Add(const GradientSums& other) {
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    gradient[i] += other.gradient[i];
    diagonal[i] += other.diagonal[i];
  }
}

void GradientSums::Add(const PixelRows& rows, const ParameterSet& set) {
  for (const RowUnit& unit : rows.units) {
    for (std::int32_t e = 0; e < unit.num_entries; ++e) {
      const RowEntry& entry = rows.entries[unit.first_entry + static_cast<std::size_t>(e)];
      const auto size = static_cast<std::size_t>(set.BlockSize(entry.block));
      const std::size_t offset = set.BlockOffset(entry.block);
      for (std::size_t c = 0; c < size; ++c) {
        double sum = -static_cast<double>(entry.noise[c]);
        double square = 0.0;
        for (int row = 0; row < unit.NumRows(); ++row) {
          const auto j =
              static_cast<double>(entry.jacobian[static_cast<std::size_t>(row) * size + c]);
          sum += j * unit.residual[static_cast<std::size_t>(row)];
          square += j * j;
        }
        gradient[offset + c] += sum;
        diagonal[offset + c] += square;
      }
    }
  }
}

GramRoot MakeGramRoot(const std::vector<double>& hessian,
                      const std::vector<double>& gradient,
                      double signal_squared,
                      double noise_squared) {
  const auto n = static_cast<Eigen::Index>(gradient.size());
  RowMajorMatrix h = Eigen::Map<const RowMajorMatrix>(hessian.data(), n, n);
  h.diagonal().array() += kRelativeShift * h.trace() / static_cast<double>(n) + 1e-300;
  const Eigen::LLT<RowMajorMatrix> factor(h);
  // Rounding can only spoil a matrix whose trace is zero, and then any root will do.
  const bool usable = factor.info() == Eigen::Success;
  const RowMajorMatrix upper =
      usable ? RowMajorMatrix(factor.matrixU()) : RowMajorMatrix(RowMajorMatrix::Zero(n, n));
  Eigen::VectorXd root = Eigen::VectorXd::Zero(n);
  if (usable) {
    root = factor.matrixL().solve(Eigen::Map<const Eigen::VectorXd>(gradient.data(), n));
  }
  GramRoot result;
  const double explained = root.squaredNorm();
  result.offset_squared =
      kNoiseRowFactor * (noise_squared + kNoiseFloorShare * signal_squared) + explained + 1e-12;
  const double rest = signal_squared - noise_squared + result.offset_squared - explained;
  if (!(rest >= 0.0) || !std::isfinite(rest)) {
    throw renderer::NumericalError(
        "the squares of residuals or derivatives overflow; photos, lights and weights must be of "
        "ordinary size");
  }
  result.residual.assign(root.data(), root.data() + n);
  result.residual.push_back(std::sqrt(rest));
  result.upper.assign(upper.data(), upper.data() + n * n);
  return result;
}

}  // namespace pathfit::optim
