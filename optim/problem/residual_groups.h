#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "optim/problem/pixel_rows.h"

namespace pathfit::optim {

/// Rows of one view that share (nearly) all their columns: one residual block of the solver.
struct ResidualGroup {
  std::size_t first_row = 0;
  std::size_t first_block = 0;  ///< into ResidualGroups::blocks
  std::size_t first_cell = 0;   ///< into ResidualGroups::cells
  std::int32_t num_rows = 0;    ///< without the noise row
  std::int32_t num_blocks = 0;
  double offset_squared = 0.0;  ///< C^2 of the noise row, fixed for the round
};

/// Dense cells of one view's groups, in float. A group's cells are, block by block, num_rows x
/// components and then one row of v^T dv.
class ResidualGroups {
 public:
  /// Groups units by support: sorted by their block lists, neighbours are joined while the cells
  /// stay within kMaxFill of the nonzeros.
  static ResidualGroups Build(const PixelRows& rows, const ParameterSet& set);

  [[nodiscard]] const std::vector<ResidualGroup>& groups() const { return groups_; }
  [[nodiscard]] const std::vector<std::int32_t>& blocks() const { return blocks_; }
  [[nodiscard]] const std::vector<float>& cells() const { return cells_; }
  /// pixel * 4 + channel of each row.
  [[nodiscard]] const std::vector<std::int64_t>& row_sources() const { return row_sources_; }

  /// Mean and half difference of the halves' residuals, one per row.
  std::vector<double> u, v;
  /// Fixes every C^2 from the present u and v: far above ||v||^2, so that the noise row adds next
  /// to nothing to J^T J.
  void FixOffsets();

  static constexpr double kMaxFill = 1.15;

 private:
  struct Builder;
  std::vector<ResidualGroup> groups_;
  std::vector<std::int32_t> blocks_;
  std::vector<float> cells_;
  std::vector<std::int64_t> row_sources_;
};

}  // namespace pathfit::optim
