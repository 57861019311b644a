#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/pixel_rows.h"

namespace pathfit::optim {

/// Sums of the pixels' shares of the gradient by theta, each share times a random sign. At a
/// minimum the shares sum to nothing, and the covariance of the draws is the gradient's by what
/// stays unexplained of the photos and by the renderings' noise, pixels taken as independent (the
/// wild bootstrap [Wu 1986]). What dense normal equations keep as QuadraticModel::scatter takes
/// count * num_scalars numbers here.
class GradientDraws {
 public:
  /// At most 52.
  static constexpr int kCount = 8;

  /// No draws.
  GradientDraws() = default;
  GradientDraws(std::size_t num_scalars, std::uint64_t seed);

  /// Rows with spreads. Same bits for any number of threads.
  void Add(const PixelRows& rows, const ParameterSet& set, std::size_t view);

  [[nodiscard]] bool Empty() const { return draws_.empty(); }
  /// Each of num_scalars; none are left.
  [[nodiscard]] std::vector<std::vector<double>> Take() { return std::exchange(draws_, {}); }

 private:
  std::uint64_t seed_ = 0;
  std::vector<std::vector<double>> draws_;
};

}  // namespace pathfit::optim
