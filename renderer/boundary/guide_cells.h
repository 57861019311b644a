#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace pathfit::renderer {

/// |value| of an integrand at u in [0, 1)^3; `index` numbers the calls.
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

}  // namespace pathfit::renderer
