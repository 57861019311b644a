#pragma once

#include <vector>

#include "optim/problem/fit_views.h"

namespace pathfit::optim {

/// Split-half costs in the unit of the solver: half the sum of r_a r_b over compared channels.
/// Unbiased by noise, and for that reason possibly negative where there is nothing but noise.
struct ImageCosts {
  double colors = 0.0, coverage = 0.0;
  double signal_squared = 0.0;  ///< sum of u^2, u = (r_a + r_b) / 2
  double noise_squared = 0.0;   ///< sum of v^2, v = (r_a - r_b) / 2
  double variance = 0.0;        ///< of Total() by noise; (u . v)^2 of each pixel is unbiased for it
  double num_colors = 0.0;      ///< channels with a residual: not where nothing is seen
  void Add(const ImageCosts& other) {
    colors += other.colors;
    coverage += other.coverage;
    signal_squared += other.signal_squared;
    noise_squared += other.noise_squared;
    variance += other.variance;
    num_colors += other.num_colors;
  }
  [[nodiscard]] double Total() const { return colors + coverage; }
};

/// Deviation of a colour channel's residual. `with_noise`: also by the noise of the
/// renderings, coverage included.
double UnexplainedResidual(const ImageCosts& costs, bool with_noise);

/// Adds one view. Returns each pixel's share of the total.
std::vector<float> AddSplitHalfCosts(const ViewLevel& level,
                                     const RowScales& scales,
                                     const renderer::Film& a,
                                     const renderer::Film& b,
                                     ImageCosts& costs);

}  // namespace pathfit::optim
