#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/pixel_rows.h"

namespace pathfit::optim {

/// J^T J of the rows of all photos as a sparse matrix of blocks, made as the rows come. What it
/// takes is the pairs of blocks that some pixel sees together, once, however many photos show them;
/// unknowns that most pixels share (lights) fill their rows. Same bits for any number of threads.
class SparseGram {
 public:
  SparseGram() = default;
  /// `set` must outlive it.
  explicit SparseGram(const ParameterSet& set);

  void Add(const PixelRows& rows);
  /// Once after all rows: scales each block's rows and columns so that those on the diagonal are
  /// without what the noise of derivatives adds to them, where the rows have spreads; of no
  /// direction less than kLeastTrueShare is left. The matrix stays positive. Where `gradient` is
  /// noise itself, the matrix keeps what noise adds, and so damps the step.
  void Deflate(const std::vector<double>& gradient);
  /// Adds a product of the sizes of the blocks, row-major, row_block <= column_block.
  void Add(std::int32_t row_block, std::int32_t column_block, std::span<const double> product);

  /// The block on the diagonal, of rows of 3.
  [[nodiscard]] std::span<const double> Diagonal(std::int32_t block) const {
    return std::span(rows_[static_cast<std::size_t>(block)].cells)
        .first(static_cast<std::size_t>(set_->BlockSize(block)) * kStride);
  }
  /// y = J^T J x.
  void Multiply(const std::vector<double>& x, std::vector<double>& y) const;

  /// Blocks that some pixel sees beside another one.
  [[nodiscard]] std::size_t NumSeen() const;
  [[nodiscard]] std::size_t MemoryBytes() const;

  /// Of a cell's rows, whatever the size of the column's block.
  static constexpr std::size_t kStride = 3;

 private:
  /// The upper triangle: columns in the order of their first pixel, that of the diagonal first;
  /// each has as many rows of kStride cells as the row's block has scalars.
  struct Row {
    std::vector<std::int32_t> columns;
    std::vector<double> cells;
  };
  static std::size_t Append(std::int32_t column, std::size_t num_cells, Row& row);

  const ParameterSet* set_ = nullptr;
  std::vector<Row> rows_;  // by block
  struct Noise {
    std::array<double, kStride * kStride> square{};  // what it adds to the diagonal's block
    std::array<double, kStride> gradient{};          // variance, by scalar
  };
  std::vector<Noise> noise_;  // by block
};

}  // namespace pathfit::optim
