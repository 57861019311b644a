#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>

namespace pathfit::tests {

/// Derivative of f at x by central differences extrapolated to step zero [Ridders 1982]. `step` is
/// the first, largest step: f must be smooth on [x - step, x + step]. Good to about 1e-10 of f''s
/// scale.
inline double RiddersDerivative(const std::function<double(double)>& f, double x, double step) {
  constexpr int kRows = 10;
  constexpr double kShrink = 1.4;
  std::array<std::array<double, kRows>, kRows> table{};
  double best = 0.0;
  double best_error = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kRows; ++i) {
    table[0][i] = (f(x + step) - f(x - step)) / (2.0 * step);
    step /= kShrink;
    double factor = kShrink * kShrink;
    for (std::size_t j = 1; j <= i; ++j) {
      table[j][i] = (table[j - 1][i] * factor - table[j - 1][i - 1]) / (factor - 1.0);
      factor *= kShrink * kShrink;
      const double error = std::max(std::abs(table[j][i] - table[j - 1][i]),
                                    std::abs(table[j][i] - table[j - 1][i - 1]));
      if (error <= best_error) {
        best_error = error;
        best = table[j][i];
      }
    }
  }
  return best;
}

/// |a - b| relative to the larger of |b| and `floor`.
inline double RelativeError(double a, double b, double floor = 1.0) {
  return std::abs(a - b) / std::max(std::abs(b), floor);
}

}  // namespace pathfit::tests
