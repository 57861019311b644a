#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pathfit::optim {

class ParameterSet;
struct PixelRows;

/// Rows of one view, summed over rounds with their weights, both halves apart.
struct SummedRows {
  /// 2 x pixel, and 1 more for its coverage; ascending.
  std::vector<std::int32_t> units;
  /// num_rows x (half a, half b), num_rows those of the units one after another.
  std::vector<double> residuals;
  /// num_rows x (half a, half b) x num_scalars.
  std::vector<float> jacobians;
};

/// Rows of all pixels, summed over rounds (SummedRows): in their products, the Jacobian of each
/// round's one half meets the residuals of all rounds' other half. What noise multiplies to then
/// falls with the square of the number of rounds; in the sum of the rounds' own products
/// (QuadraticModel), only with that number. Empty: no round yet.
struct RowHistory {
  double weight = 0.0;            ///< of the rounds together
  std::vector<double> theta;      ///< at which the residuals are, by the rounds' Jacobians
  std::vector<SummedRows> views;  ///< by fitted view

  RowHistory() = default;
  RowHistory(std::size_t num_views, std::size_t num_scalars);
  [[nodiscard]] bool Empty() const { return weight == 0.0; }

  /// Of so many pixels.
  static double Bytes(double num_pixels, std::size_t num_scalars, bool with_coverage);
  /// Whether the sizes fit each other and all is finite.
  [[nodiscard]] bool IsValid() const;

  /// All rounds as if they had had that share of their samples.
  void Fade(double kept);
  /// Adds a round at `at`: all rows of each view, those without derivatives, too.
  void Add(const std::vector<PixelRows>& round,
           const std::vector<double>& at,
           double round_weight,
           const ParameterSet& set);
  /// Means over the rounds, at theta.
  [[nodiscard]] PixelRows Means(std::size_t view, const ParameterSet& set) const;
};

}  // namespace pathfit::optim
