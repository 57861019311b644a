#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/pixel_rows.h"

namespace pathfit::optim {

/// Rows of all views whose derivatives lie within one set of blocks, as few as have the same normal
/// equations. Columns are those of `blocks`, in their order.
struct Support {
  std::vector<std::int32_t> blocks;  ///< local ones ascending, then shared ones ascending
  std::size_t num_local = 0;         ///< of the blocks
  std::size_t num_local_columns = 0;
  std::size_t num_columns = 0;
  std::int64_t num_rows = 0;   ///< seen in photos
  double noise_squared = 0.0;  ///< |v|^2 of these
  /// Whether the rows have become a triangular root: row i has the columns from i on, i below
  /// num_local_columns. Otherwise they are the rows themselves with all columns.
  bool is_root = false;
  std::vector<float> rows;
  std::vector<double> residual;  ///< by row
  std::vector<float> spreads;    ///< by row and local column, until the root is made
  std::vector<double> noise;     ///< by local column: what the halves' noise adds to the gradient
  double offset_squared = 0.0;   ///< C^2 of the noise row

  // While rows are added to a root: upper trapezoid of J^T J, and J^T u.
  std::vector<double> matrix, gradient;
  /// Upper triangle of the same by the halves' differences, local columns only: what noise adds to
  /// J^T J.
  std::vector<float> inflation;

  [[nodiscard]] std::size_t NumRows() const {
    return is_root ? num_local_columns : residual.size();
  }
  /// Of a cell in `inflation`; column >= row.
  [[nodiscard]] std::size_t InflationCell(std::size_t row, std::size_t column) const {
    return row * num_local_columns - row * (row + 1) / 2 + column;
  }
  /// Of a root's row in `rows` or `matrix`.
  [[nodiscard]] std::size_t RowOffset(std::size_t row) const {
    return is_root ? row * num_columns - row * (row - 1) / 2 - row : row * num_columns;
  }
};

/// Consecutive rows of one support, and their blocks from the first that is not zero on: one
/// residual block of the solver. The first panel of a support ends with its noise row.
struct RootPanel {
  std::int32_t support = 0;
  std::int32_t first_block = 0, num_blocks = 0;  ///< of the support's
  std::int32_t first_column = 0;
  std::int32_t first_row = 0, num_rows = 0;  ///< without the noise row
  bool has_noise_row = false;
};

/// What supports cost in the solver.
struct RootSize {
  double gathered_bytes = 0.0;  ///< ours while rows are added
  double kept_bytes = 0.0;      ///< ours once the roots are made
  double num_panels = 0.0;
  double panel_blocks = 0.0;    ///< sum over panels of their blocks
  double jacobian_cells = 0.0;  ///< with noise rows
  double product_cells = 0.0;   ///< sum over panels of blocks^2 / 2: terms of J^T J
};

/// The least-squares rows of all photos, collapsed as they come: supports that overlap are joined
/// where that takes less memory, and a support with more rows than columns keeps its normal
/// equations only, exactly. What is kept so depends on the unknowns and hardly on the number and
/// size of photos. Blocks that most pixels share (lights, cameras, small environments) are
/// eliminated from every support into one of their own. Same bits for any number of threads.
class SupportRoots {
 public:
  /// `set` must outlive it.
  SupportRoots(const ParameterSet& set, std::size_t num_views);

  /// Begins the next view: more rows of supports seen so far are expected from those to come.
  void BeginView() { ++view_; }
  /// Adds rows of the view.
  void Add(const PixelRows& rows);
  /// Makes the roots. With J = rows of all supports and r their residuals, J^T J is that of the
  /// pixels' rows, in roots of rows with spreads without the noise of the local blocks'
  /// derivatives, and J^T r with the noise rows' part their split-half gradient. Throws
  /// renderer::NumericalError if sums overflow.
  void Finish();

  /// After Finish.
  [[nodiscard]] const std::vector<Support>& supports() const { return supports_; }
  [[nodiscard]] const std::vector<RootPanel>& panels() const { return panels_; }
  /// Sum of the squares of all residuals, noise rows included.
  [[nodiscard]] double residual_squared() const { return residual_squared_; }
  /// Before Finish with what is expected of the views to come, after it of all.
  [[nodiscard]] RootSize Size() const;

 private:
  struct Range;
  struct Touched;
  struct DenseRows;
  struct SharedRows;
  class Assigner;

  [[nodiscard]] std::size_t Columns(std::int32_t block) const {
    return static_cast<std::size_t>(set_.BlockSize(block));
  }
  /// All rows over those of the views so far.
  [[nodiscard]] double ExpectedGrowth() const;
  /// By scalar of `blocks`, which are the support's, local ones first.
  [[nodiscard]] std::vector<std::size_t> ColumnsIn(const Support& support,
                                                   const std::vector<std::int32_t>& blocks) const;
  /// Runs the body for [0, count), any order; what it returns by shared blocks is added, times
  /// `sign`, in the order of calls.
  void ForBatches(std::size_t count,
                  double sign,
                  const std::function<void(std::size_t, std::vector<SharedRows>&)>& body);
  void AddShared(const std::vector<std::vector<SharedRows>>& parts, double sign);
  void Fill(const PixelRows& rows,
            const std::vector<std::size_t>& order,
            const Touched& touched,
            std::vector<SharedRows>& shared);
  void Widen(const Touched& touched, Support& support) const;
  void AddToRoot(DenseRows dense,
                 const std::vector<std::size_t>& columns,
                 const std::vector<std::int32_t>& shared_blocks,
                 Support& support,
                 std::vector<SharedRows>& shared) const;
  void MakeRoot(Support& support, std::vector<SharedRows>& shared) const;
  /// Takes from J^T J what noise adds to it, where the halves' differences are known: of no
  /// direction more than leaves kLeastTrueShare.
  static void Deflate(Support& support);
  void Factor(Support& support, std::vector<SharedRows>& eliminated) const;
  void AppendPanels(std::int32_t id,
                    const Support& support,
                    bool as_root,
                    std::vector<RootPanel>& panels) const;

  const ParameterSet& set_;
  std::size_t num_views_, view_ = 0;
  std::vector<char> is_shared_;             // by block
  std::vector<std::size_t> shared_column_;  // by block
  std::vector<Support> supports_;           // the first is that of the shared blocks
  std::vector<std::vector<std::int32_t>> supports_of_block_;  // local ones, ascending
  std::vector<RootPanel> panels_;
  double num_rows_ = 0.0, signal_squared_ = 0.0, noise_squared_ = 0.0, residual_squared_ = 0.0;
};

}  // namespace pathfit::optim
