#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "renderer/boundary/guide_cells.h"
#include "renderer/render_options.h"

namespace pathfit::renderer {

/// Density over the primary samples [0, 1)^3 of a boundary estimator, learned from pilot samples:
/// cells hold the root mean square of the pilot values, so that the guided estimator's variance is
/// least. A share of the density stays uniform (relative floor): a cell whose pilots were all zero
/// is still drawn. The estimator's mean does not depend on the guide. [path_space 2.5]
class PrimaryGuide {
 public:
  struct Draw {
    std::array<double, 3> u;  ///< in [0, 1)
    double pdf = 1.0;         ///< relative to the uniform density
  };
  /// |value| of the integrand over the primary samples at u; `index` numbers the pilot, so that the
  /// function can draw further numbers of its own. Called from several threads at once. Values that
  /// are not finite are ignored.
  using Pilot = GuidePilot;

  /// Uniform.
  PrimaryGuide() = default;
  /// Spends about `num_pilots` calls. `dimensions` 1..3: only the first ones are guided (delta
  /// lights use one). The result is a function of its arguments, not of threads.
  static PrimaryGuide Build(GuideKind kind,
                            int dimensions,
                            std::int64_t num_pilots,
                            const Pilot& pilot);

  /// Maps three uniform numbers; keeps stratification (monotone along the cells' order in u0).
  [[nodiscard]] Draw Sample(double u0, double u1, double u2) const;
  /// Mean of the pilot values over [0, 1)^3: how the budget is divided between estimators.
  [[nodiscard]] double Mass() const { return mass_; }
  [[nodiscard]] std::int64_t NumPilots() const { return num_pilots_; }

  static constexpr double kUniformShare = 0.1;

 private:
  struct Cell {
    std::array<double, 3> low, size;
    double pdf = 1.0;  // relative to uniform, floor included
  };

  explicit PrimaryGuide(std::span<const GuideCell> cells, std::int64_t num_pilots);

  std::vector<Cell> cells_;         // none: uniform
  std::vector<double> cumulative_;  // probability of the cells before
  double mass_ = 0.0;
  std::int64_t num_pilots_ = 0;
};

}  // namespace pathfit::renderer
