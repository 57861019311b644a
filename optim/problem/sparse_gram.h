#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/pixel_rows.h"

namespace pathfit::optim {

/// The blocks of a set that keep pairs: all, unless there are so many texels that their pairs would
/// not fit. Those are spread (SparseGram). The others are numbered without them, and vectors of
/// their scalars are called short.
class PairedBlocks {
 public:
  PairedBlocks() = default;
  explicit PairedBlocks(const ParameterSet& set);

  [[nodiscard]] std::size_t NumBlocks() const { return num_blocks_; }
  [[nodiscard]] std::size_t NumScalars() const { return num_scalars_; }
  [[nodiscard]] std::size_t NumSpreadScalars() const;
  /// Of a block among them, -1 if it is spread.
  [[nodiscard]] std::int32_t RowOf(std::int32_t block) const {
    std::int32_t row = block;
    for (const Spread& spread : spread_) {
      if (block < spread.first_block) break;
      if (block < spread.end_block) return -1;
      row -= spread.end_block - spread.first_block;
    }
    return row;
  }
  [[nodiscard]] std::int32_t BlockOf(std::size_t row) const;
  /// Of a full vector.
  [[nodiscard]] std::vector<double> Shorten(const std::vector<double>& full) const;
  /// Calls body(first, end) for the full vector's scalars of each run of paired, or spread, blocks.
  template <class Body>
  void ForPaired(const Body& body) const {
    std::size_t first = 0;
    for (const Spread& spread : spread_) {
      body(first, spread.first_scalar);
      first = spread.end_scalar;
    }
    body(first, num_all_scalars_);
  }
  template <class Body>
  void ForSpread(const Body& body) const {
    for (const Spread& spread : spread_) body(spread.first_scalar, spread.end_scalar);
  }

  /// More texels than these are spread. All pairs of so many would take about 1 GB where texels are
  /// as large as pixels; where they are smaller, a pixel sees hundreds at once.
  static constexpr std::int64_t kMaxPairedTexels = 500'000;

 private:
  struct Spread {
    std::int32_t first_block = 0, end_block = 0;
    std::size_t first_scalar = 0, end_scalar = 0;
  };
  std::vector<Spread> spread_;  ///< ascending
  std::size_t num_blocks_ = 0, num_scalars_ = 0, num_all_scalars_ = 0;
};

/// J^T J of the rows of all photos as a sparse matrix of blocks, made as the rows come. What it
/// takes is the pairs of blocks that some pixel sees together, once, however many photos show them;
/// unknowns that most pixels share (lights) fill their rows. Same bits for any number of threads.
///
/// Of spread blocks (PairedBlocks) only a diagonal is kept that bounds the matrix from above: a
/// row's square (sum_j a_j x_j)^2 is at most sum_j |a_j| sum_k |a_k| x_j^2 [De Pierro 1995], which
/// is as much as there is to know where a pixel sees many texels at once: it says what they are
/// together. Between them and the other blocks of a row, (s + p)^2 <= 2 s^2 + 2 p^2.
class SparseGram {
 public:
  SparseGram() = default;
  /// `set` must outlive it.
  explicit SparseGram(const ParameterSet& set);

  void Add(const PixelRows& rows);
  /// Once after all rows: scales each block's rows and columns so that those on the diagonal are
  /// without what the noise of derivatives adds to them, where the rows have spreads; of no
  /// direction less than kLeastTrueShare is left. The matrix stays positive. Where `gradient` is
  /// noise itself, the matrix keeps what noise adds, and so damps the step; without a gradient all
  /// that noise adds goes.
  void Deflate(const std::vector<double>& gradient);
  /// Adds a product of the sizes of the blocks, row-major, row_block <= column_block; of spread
  /// blocks a bound of it.
  void Add(std::int32_t row_block, std::int32_t column_block, std::span<const double> product);

  [[nodiscard]] const PairedBlocks& paired() const { return paired_; }
  /// The block on the diagonal, of rows of 3, by its number among the paired ones.
  [[nodiscard]] std::span<const double> Diagonal(std::size_t row) const;
  /// By scalar, zero for paired blocks; empty if no block is spread.
  [[nodiscard]] const std::vector<double>& spread_diagonal() const { return spread_diagonal_; }
  /// y = J^T J x for short vectors.
  void Multiply(const std::vector<double>& x, std::vector<double>& y) const;

  /// Paired blocks that some pixel sees beside another one.
  [[nodiscard]] std::size_t NumSeen() const;
  /// Without what a block of the set takes that nothing sees.
  [[nodiscard]] std::size_t MemoryBytes() const;
  /// What it takes before any row comes.
  static std::size_t BytesOfEmpty(const ParameterSet& set);

  /// Of a cell's rows, whatever the size of the column's block.
  static constexpr std::size_t kStride = 3;

 private:
  struct Noise {
    std::array<double, kStride * kStride> square{};  // what it adds to the diagonal's block
    std::array<double, kStride> gradient{};          // variance, by scalar
  };
  /// The upper triangle: columns in the order of their first pixel, that of the diagonal first;
  /// each has as many rows of kStride cells as the row's block has scalars. Empty until something
  /// sees the block.
  struct Row {
    std::vector<std::int32_t> columns;  // as rows are numbered
    std::vector<double> cells;
    std::unique_ptr<Noise> noise;
  };
  static std::size_t Append(std::int32_t column, std::size_t num_cells, Row& row);
  [[nodiscard]] Row& Begun(std::size_t row);
  /// Of a unit's squares: 2 if it has both spread and paired blocks.
  [[nodiscard]] double WeightOf(const PixelRows& rows, const RowUnit& unit) const;
  void Spread(const PixelRows& rows);

  const ParameterSet* set_ = nullptr;
  PairedBlocks paired_;
  std::vector<Row> rows_;  // by paired block
  std::vector<std::uint8_t> sizes_;
  std::vector<std::size_t> offsets_;  // in short vectors, by paired block
  std::vector<double> spread_diagonal_;
};

}  // namespace pathfit::optim
