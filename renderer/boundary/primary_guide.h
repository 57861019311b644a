#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "renderer/render_options.h"

namespace pathfit::renderer {

/// |value| of an integrand over the primary samples at u in [0, 1)^3; `index` numbers the calls, so
/// that the function can draw further numbers of its own. Called from several threads at once.
/// Values that are not finite are ignored.
using GuidePilot = std::function<double(const std::array<double, 3>& u, std::int64_t index)>;

/// A box of the unit cube with what its pilots say of the integrand there.
struct GuideCell {
  std::array<double, 3> low{};
  std::array<double, 3> size{1.0, 1.0, 1.0};
  double mean = 0.0;
  double mean_square = 0.0;

  [[nodiscard]] double Volume() const { return size[0] * size[1] * size[2]; }
};

/// A regular grid, finest along the first axis; cells in the order of their first, then second,
/// then third coordinate. Only the first `dimensions` axes are cut.
std::vector<GuideCell> GridCells(int dimensions, std::int64_t num_pilots, const GuidePilot& pilot);

/// Cells halved where that makes the most of the pilots, in several rounds: each draws pilots by
/// the cells' share of the root mean square, so that small strong regions get finer and finer
/// cells. Neighbours in the list are neighbours in the cube.
std::vector<GuideCell> AdaptiveCells(int dimensions,
                                     std::int64_t num_pilots,
                                     const GuidePilot& pilot);

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
  /// Uniform.
  PrimaryGuide() = default;
  /// Calls the pilot `num_pilots` times. `dimensions` 1..3: only the first ones are guided (delta
  /// lights use one). The result is a function of its arguments, not of threads.
  static PrimaryGuide Build(GuideKind kind,
                            int dimensions,
                            std::int64_t num_pilots,
                            const GuidePilot& pilot);

  /// Maps three uniform numbers; keeps stratification (monotone along the cells' order in u0).
  [[nodiscard]] Draw Sample(double u0, double u1, double u2) const;
  /// Mean of the pilot values over [0, 1)^3: how the budget is divided between estimators.
  [[nodiscard]] double Mass() const { return mass_; }

  static constexpr double kUniformShare = 0.1;

 private:
  struct Cell {
    std::array<double, 3> low, size;
    double pdf = 1.0;  // relative to uniform, floor included
  };

  explicit PrimaryGuide(std::span<const GuideCell> cells);

  std::vector<Cell> cells_;         // none: uniform
  std::vector<double> cumulative_;  // probability of the cells before
  double mass_ = 0.0;
};

/// By view and technique: the guides of all its ways.
struct GuideStore::Guides {
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::vector<PrimaryGuide>> of;
};

}  // namespace pathfit::renderer
