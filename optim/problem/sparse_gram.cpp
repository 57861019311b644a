#include "optim/problem/sparse_gram.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "renderer/core/check.h"
#include "renderer/core/parallel.h"

namespace pathfit::optim {
namespace {

// Pieces of the matrix that are worked on at once; sums do not depend on threads, but on these.
constexpr std::size_t kChunks = 8;
constexpr double kRelativeShift = 1e-9;  // of a block's trace: makes its factor exist

struct ChunkRange {
  std::size_t first, end;
};
ChunkRange RangeOf(std::int64_t chunk, std::size_t count) {
  const auto c = static_cast<std::size_t>(chunk);
  return {c * count / kChunks, (c + 1) * count / kChunks};
}

/// An entry of a unit, both by index.
struct Incidence {
  std::uint32_t unit, entry;
};

/// The entries of each block, in the order of units: those of block b are list[first[b] ..
/// first[b + 1]).
struct Incidences {
  std::vector<std::size_t> first;
  std::vector<Incidence> list;
};

Incidences SortByBlock(const PixelRows& rows, const PairedBlocks& paired) {
  const std::size_t num_blocks = paired.NumBlocks();
  Incidences sorted;
  sorted.first.assign(num_blocks + 1, 0);
  std::size_t num_entries = 0;
  for (const RowEntry& entry : rows.entries) {
    const std::int32_t row = paired.RowOf(entry.block);
    if (row < 0) continue;
    ++sorted.first[static_cast<std::size_t>(row) + 1];
    ++num_entries;
  }
  for (std::size_t b = 0; b < num_blocks; ++b) {
    sorted.first[b + 1] += sorted.first[b];
  }
  sorted.list.resize(num_entries);
  std::vector<std::size_t> next(sorted.first.begin(), sorted.first.end() - 1);
  for (std::size_t u = 0; u < rows.units.size(); ++u) {
    const RowUnit& unit = rows.units[u];
    for (std::size_t e = 0; e < static_cast<std::size_t>(unit.num_entries); ++e) {
      const std::size_t index = unit.first_entry + e;
      const std::int32_t row = paired.RowOf(rows.entries[index].block);
      if (row < 0) continue;
      sorted.list[next[static_cast<std::size_t>(row)]++] = {static_cast<std::uint32_t>(u),
                                                            static_cast<std::uint32_t>(index)};
    }
  }
  return sorted;
}

constexpr std::int64_t kPieces = 64;  // of rows that are added at once: any number, same bits

/// The first row of a piece: pieces have about as many incidences, as few rows may have most (those
/// of lights).
std::size_t FirstOfPiece(const Incidences& sorted, std::int64_t piece) {
  const std::size_t begin = static_cast<std::size_t>(piece) * sorted.list.size() / kPieces;
  const auto found = std::ranges::lower_bound(sorted.first, begin);
  return std::min(static_cast<std::size_t>(found - sorted.first.begin()), sorted.first.size() - 1);
}

/// A number of an entry's Jacobian that is not zero, with its unit's weight.
struct Factor {
  std::size_t row, component;
  double value;
};
using Factors = std::array<Factor, 9>;

/// Colours and lights act on a channel each: most of their numbers are zero.
std::size_t FactorsOf(
    const RowEntry& entry, std::size_t num_rows, std::size_t size, double weight, Factors& out) {
  std::size_t count = 0;
  for (std::size_t r = 0; r < num_rows; ++r) {
    for (std::size_t p = 0; p < size; ++p) {
      const double value = weight * static_cast<double>(entry.jacobian[r * size + p]);
      if (value != 0.0) {
        out[count++] = {r, p, value};
      }
    }
  }
  return count;
}

/// Adds factors^T other.
template <std::size_t kWidth>
void AddProducts(std::span<const Factor> factors, const RowEntry& other, double* cells) {
  for (const Factor& factor : factors) {
    const float* of_row = other.jacobian.data() + factor.row * kWidth;
    double* sums = cells + factor.component * SparseGram::kStride;
    for (std::size_t q = 0; q < kWidth; ++q) {
      sums[q] += factor.value * static_cast<double>(of_row[q]);
    }
  }
}

/// Adds a cell times what it meets of the other block, and of its own to the other; null: it is on
/// the diagonal.
template <std::size_t kWidth>
void MultiplyCell(const double* cells,
                  std::size_t size,
                  const std::array<double, SparseGram::kStride>& own,
                  const double* of_other,
                  std::array<double, SparseGram::kStride>& sums,
                  double* to_other) {
  for (std::size_t p = 0; p < size; ++p) {
    const double* of_row = cells + p * SparseGram::kStride;
    for (std::size_t q = 0; q < kWidth; ++q) {
      sums[p] += of_row[q] * of_other[q];
    }
    if (to_other != nullptr) {
      for (std::size_t q = 0; q < kWidth; ++q) {
        to_other[q] += of_row[q] * own[p];
      }
    }
  }
}

// Incidences that are fetched ahead: their entries lie all over memory.
constexpr std::size_t kAhead = 4;

void Prefetch(const PixelRows& rows, const Incidence& incidence) {
  __builtin_prefetch(&rows.units[incidence.unit]);
  __builtin_prefetch(&rows.entries[incidence.entry]);
  if (!rows.spreads.empty()) {
    __builtin_prefetch(&rows.spreads[incidence.entry]);
  }
}

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, 3, 3>;
using CellMap = Eigen::Map<RowMajor, 0, Eigen::OuterStride<>>;
using ConstCellMap = Eigen::Map<const RowMajor, 0, Eigen::OuterStride<>>;

/// C such that C A C^T is A, which begins `cells`, without a share of `noise`: with A = L L^T and
/// the eigenvectors Q of L^-1 noise L^-T, C = L Q sqrt(share) Q^T L^-1.
Eigen::Matrix3d ScaleWithout(
    double share,
    const std::array<double, SparseGram::kStride * SparseGram::kStride>& noise,
    const std::vector<double>& cells,
    Eigen::Index size) {
  const Eigen::OuterStride<> stride(SparseGram::kStride);
  Eigen::Matrix3d square = Eigen::Matrix3d::Identity(), part = Eigen::Matrix3d::Zero();
  square.topLeftCorner(size, size) = ConstCellMap(cells.data(), size, size, stride);
  part.topLeftCorner(size, size) = share * ConstCellMap(noise.data(), size, size, stride);
  const double trace = square.topLeftCorner(size, size).trace();
  if (!(trace > 0.0) || !std::isfinite(trace) || part.isZero(0.0)) {
    return Eigen::Matrix3d::Identity();
  }
  square.diagonal().array() += kRelativeShift * trace;
  const Eigen::LLT<Eigen::Matrix3d> factor(square);
  const Eigen::Matrix3d lower = factor.matrixL();
  const Eigen::Matrix3d inverse =
      lower.triangularView<Eigen::Lower>().solve(Eigen::Matrix3d::Identity());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> shares(inverse * part * inverse.transpose());
  if (factor.info() != Eigen::Success || shares.info() != Eigen::Success) {
    return Eigen::Matrix3d::Identity();
  }
  const Eigen::Matrix3d& vectors = shares.eigenvectors();
  const Eigen::Vector3d roots =
      (1.0 - shares.eigenvalues().array()).cwiseMax(kLeastTrueShare).cwiseMin(1.0).sqrt();
  return lower * vectors * roots.asDiagonal() * vectors.transpose() * inverse;
}

}  // namespace

PairedBlocks::PairedBlocks(const ParameterSet& set)
    : num_blocks_(set.NumBlocks()),
      num_scalars_(set.NumScalars()),
      num_all_scalars_(set.NumScalars()) {
  const auto is_texels = [](const renderer::ParameterGroup& group) {
    return group.kind == renderer::ParameterKind::kTextureTexels;
  };
  std::int64_t num_texels = 0;
  for (const renderer::ParameterGroup& group : set.layout().groups()) {
    num_texels += is_texels(group) ? group.num_blocks : 0;
  }
  if (num_texels <= kMaxPairedTexels) return;
  for (const renderer::ParameterGroup& group : set.layout().groups()) {
    if (!is_texels(group)) continue;
    const auto num_blocks = static_cast<std::size_t>(group.num_blocks);
    const auto first = static_cast<std::size_t>(group.first_scalar);
    const std::size_t num_scalars = num_blocks * static_cast<std::size_t>(group.block_size);
    spread_.push_back(
        {group.first_block, group.first_block + group.num_blocks, first, first + num_scalars});
    num_blocks_ -= num_blocks;
    num_scalars_ -= num_scalars;
  }
}

std::size_t PairedBlocks::NumSpreadScalars() const { return num_all_scalars_ - num_scalars_; }

std::int32_t PairedBlocks::BlockOf(std::size_t row) const {
  auto block = static_cast<std::int32_t>(row);
  for (const Spread& spread : spread_) {
    if (block < spread.first_block) break;
    block += spread.end_block - spread.first_block;
  }
  return block;
}

std::vector<double> PairedBlocks::Shorten(const std::vector<double>& full) const {
  std::vector<double> values;
  values.reserve(num_scalars_);
  ForPaired([&](std::size_t first, std::size_t end) {
    values.insert(values.end(),
                  full.begin() + static_cast<std::ptrdiff_t>(first),
                  full.begin() + static_cast<std::ptrdiff_t>(end));
  });
  return values;
}

SparseGram::SparseGram(const ParameterSet& set)
    : set_(&set),
      paired_(set),
      rows_(paired_.NumBlocks()),
      spread_diagonal_(paired_.NumSpreadScalars() > 0 ? set.NumScalars() : 0) {
  sizes_.reserve(rows_.size());
  offsets_.reserve(rows_.size());
  std::size_t offset = 0;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const int size = set.BlockSize(paired_.BlockOf(row));
    sizes_.push_back(static_cast<std::uint8_t>(size));
    offsets_.push_back(offset);
    offset += static_cast<std::size_t>(size);
  }
}

SparseGram::Row& SparseGram::Begun(std::size_t row) {
  Row& begun = rows_[row];
  if (begun.columns.empty()) {
    Append(static_cast<std::int32_t>(row), sizes_[row] * kStride, begun);
  }
  return begun;
}

std::span<const double> SparseGram::Diagonal(std::size_t row) const {
  static constexpr std::array<double, kStride * kStride> kUnseen{};
  const std::span<const double> cells =
      rows_[row].cells.empty() ? std::span<const double>(kUnseen) : rows_[row].cells;
  return cells.first(sizes_[row] * kStride);
}

std::size_t SparseGram::Append(std::int32_t column, std::size_t num_cells, Row& row) {
  const std::size_t position = row.columns.size();
  if (position == row.columns.capacity()) {
    // Doubling would take half as much again, and columns rarely come one by one.
    const std::size_t room = position + std::max<std::size_t>(4, position / 4);
    row.columns.reserve(room);
    row.cells.reserve(room * num_cells);
  }
  row.columns.push_back(column);
  row.cells.resize(row.cells.size() + num_cells);
  return position;
}

double SparseGram::WeightOf(const PixelRows& rows, const RowUnit& unit) const {
  if (spread_diagonal_.empty()) {
    return 1.0;
  }
  bool any_spread = false, any_paired = false;
  for (std::int32_t e = 0; e < unit.num_entries; ++e) {
    const RowEntry& entry = rows.entries[unit.first_entry + static_cast<std::size_t>(e)];
    (paired_.RowOf(entry.block) < 0 ? any_spread : any_paired) = true;
  }
  return any_spread && any_paired ? 2.0 : 1.0;
}

void SparseGram::Spread(const PixelRows& rows) {
  if (spread_diagonal_.empty()) {
    return;
  }
  for (const RowUnit& unit : rows.units) {
    const double weight = WeightOf(rows, unit);
    const auto num_rows = static_cast<std::size_t>(unit.NumRows());
    const auto for_entries = [&](const auto& body) {
      for (std::int32_t e = 0; e < unit.num_entries; ++e) {
        const RowEntry& entry = rows.entries[unit.first_entry + static_cast<std::size_t>(e)];
        if (paired_.RowOf(entry.block) < 0) {
          body(entry, static_cast<std::size_t>(set_->BlockSize(entry.block)));
        }
      }
    };
    std::array<double, 3> sums{};  // by row
    for_entries([&](const RowEntry& entry, std::size_t size) {
      for (std::size_t k = 0; k < num_rows * size; ++k) {
        sums[k / size] += std::abs(static_cast<double>(entry.jacobian[k]));
      }
    });
    for_entries([&](const RowEntry& entry, std::size_t size) {
      double* diagonal = spread_diagonal_.data() + set_->BlockOffset(entry.block);
      for (std::size_t k = 0; k < num_rows * size; ++k) {
        diagonal[k % size] +=
            weight * std::abs(static_cast<double>(entry.jacobian[k])) * sums[k / size];
      }
    });
  }
}

void SparseGram::Add(const PixelRows& rows) {
  Spread(rows);
  const Incidences sorted = SortByBlock(rows, paired_);
  renderer::ParallelFor(kPieces, [&](std::int64_t piece) {
    // Of a column in the row; -1 again after each row.
    static thread_local std::vector<std::int32_t> position;
    position.resize(std::max(position.size(), rows_.size()), -1);
    Factors kept;
    const std::size_t first = FirstOfPiece(sorted, piece);
    const std::size_t end_row = FirstOfPiece(sorted, piece + 1);
    for (std::size_t b = first; b < end_row; ++b) {
      if (sorted.first[b] == sorted.first[b + 1]) {
        continue;
      }
      Row& row = Begun(b);
      const std::size_t size = sizes_[b];
      const std::size_t num_cells = size * kStride;
      if (!rows.spreads.empty() && row.noise == nullptr) {
        row.noise = std::make_unique<Noise>();
      }
      for (std::size_t k = 0; k < row.columns.size(); ++k) {
        position[static_cast<std::size_t>(row.columns[k])] = static_cast<std::int32_t>(k);
      }
      for (std::size_t i = sorted.first[b]; i < sorted.first[b + 1]; ++i) {
        if (i + kAhead < sorted.list.size()) {
          Prefetch(rows, sorted.list[i + kAhead]);
        }
        const RowUnit& unit = rows.units[sorted.list[i].unit];
        const auto num_rows = static_cast<std::size_t>(unit.NumRows());
        const RowEntry& own = rows.entries[sorted.list[i].entry];
        const std::size_t end = unit.first_entry + static_cast<std::size_t>(unit.num_entries);
        const double weight = WeightOf(rows, unit);
        if (!rows.spreads.empty()) {
          const EntrySpread& spread = rows.spreads[sorted.list[i].entry];
          for (std::size_t p = 0; p < size; ++p) {
            const auto of_gradient = static_cast<double>(spread.gradient[p]);
            row.noise->gradient[p] += of_gradient * of_gradient;
          }
          for (std::size_t r = 0; r < num_rows; ++r) {
            for (std::size_t p = 0; p < size; ++p) {
              for (std::size_t q = 0; q < size; ++q) {
                row.noise->square[p * kStride + q] +=
                    weight * static_cast<double>(spread.jacobian[r * size + p]) *
                    static_cast<double>(spread.jacobian[r * size + q]);
              }
            }
          }
        }
        const std::span<const Factor> factors(kept.data(),
                                              FactorsOf(own, num_rows, size, weight, kept));
        for (std::size_t e = sorted.list[i].entry; e < end; ++e) {
          const RowEntry& other = rows.entries[e];
          const std::int32_t column = paired_.RowOf(other.block);
          if (column < 0) {
            continue;
          }
          auto& place = position[static_cast<std::size_t>(column)];
          if (place < 0) {
            place = static_cast<std::int32_t>(Append(column, num_cells, row));
          }
          double* cells = row.cells.data() + static_cast<std::size_t>(place) * num_cells;
          switch (sizes_[static_cast<std::size_t>(column)]) {
            case 1:
              AddProducts<1>(factors, other, cells);
              break;
            case 2:
              AddProducts<2>(factors, other, cells);
              break;
            default:
              AddProducts<3>(factors, other, cells);
          }
        }
      }
      for (const std::int32_t column : row.columns) {
        position[static_cast<std::size_t>(column)] = -1;
      }
    }
  });
}

void SparseGram::Deflate(const std::vector<double>& gradient) {
  const std::vector<double> paired_gradient =
      gradient.empty() ? std::vector<double>() : paired_.Shorten(gradient);
  // What a block is scaled by takes the place of its noise.
  renderer::ParallelFor(kChunks, [&](std::int64_t chunk) {
    const ChunkRange range = RangeOf(chunk, rows_.size());
    for (std::size_t b = range.first; b < range.end; ++b) {
      Row& row = rows_[b];
      if (row.noise == nullptr) {
        continue;
      }
      const std::size_t size = sizes_[b];
      double squares = 0.0;  // of the gradient in its standard deviations
      for (std::size_t p = 0; p < size && !gradient.empty(); ++p) {
        const double g = paired_gradient[offsets_[b] + p];
        squares += g == 0.0 ? 0.0 : g * g / row.noise->gradient[p];
      }
      // As means are shrunk by their noise [James and Stein 1961].
      const double share =
          gradient.empty() ? 1.0 : std::max(0.0, 1.0 - static_cast<double>(size) / squares);
      Eigen::Map<Eigen::Matrix3d>(row.noise->square.data()) =
          ScaleWithout(share, row.noise->square, row.cells, static_cast<Eigen::Index>(size));
    }
  });
  renderer::ParallelFor(kChunks, [&](std::int64_t chunk) {
    const ChunkRange range = RangeOf(chunk, rows_.size());
    const auto scale_of = [&](std::size_t row) {
      const auto& noise = rows_[row].noise;
      return noise == nullptr ? Eigen::Matrix3d::Identity().eval()
                              : Eigen::Map<const Eigen::Matrix3d>(noise->square.data()).eval();
    };
    for (std::size_t b = range.first; b < range.end; ++b) {
      Row& row = rows_[b];
      const Eigen::Index size{sizes_[b]};
      const Eigen::Matrix3d left = scale_of(b);
      for (std::size_t k = 0; k < row.columns.size(); ++k) {
        const auto column = static_cast<std::size_t>(row.columns[k]);
        const Eigen::Index width{sizes_[column]};
        CellMap cell(row.cells.data() + k * static_cast<std::size_t>(size) * kStride,
                     size,
                     width,
                     Eigen::OuterStride<>(kStride));
        cell = (left.topLeftCorner(size, size) * cell *
                scale_of(column).topLeftCorner(width, width).transpose())
                   .eval();
      }
    }
  });
  for (Row& row : rows_) {
    row.noise.reset();
  }
}

void SparseGram::Add(std::int32_t row_block,
                     std::int32_t column_block,
                     std::span<const double> product) {
  PATHFIT_DCHECK(row_block <= column_block);
  const auto size = static_cast<std::size_t>(set_->BlockSize(row_block));
  const auto width = static_cast<std::size_t>(set_->BlockSize(column_block));
  const std::int32_t at = paired_.RowOf(row_block), column = paired_.RowOf(column_block);
  if (at < 0 || column < 0) {
    // Dominant diagonals. Priors are of one kind of blocks each.
    PATHFIT_DCHECK(at < 0 && column < 0);
    double* of_row = spread_diagonal_.data() + set_->BlockOffset(row_block);
    double* of_column = spread_diagonal_.data() + set_->BlockOffset(column_block);
    for (std::size_t k = 0; k < size * width; ++k) {
      of_row[k / width] += std::abs(product[k]);
      of_column[k % width] += row_block == column_block ? 0.0 : std::abs(product[k]);
    }
    return;
  }
  Row& row = Begun(static_cast<std::size_t>(at));
  const auto found = std::ranges::find(row.columns, column);
  const std::size_t place = found != row.columns.end()
                                ? static_cast<std::size_t>(found - row.columns.begin())
                                : Append(column, size * kStride, row);
  double* cells = row.cells.data() + place * size * kStride;
  for (std::size_t p = 0; p < size; ++p) {
    for (std::size_t q = 0; q < width; ++q) {
      cells[p * kStride + q] += product[p * width + q];
    }
  }
}

void SparseGram::Multiply(const std::vector<double>& x, std::vector<double>& y) const {
  std::vector<std::vector<double>> parts(kChunks);
  renderer::ParallelFor(kChunks, [&](std::int64_t chunk) {
    std::vector<double>& part = parts[static_cast<std::size_t>(chunk)];
    part.assign(x.size(), 0.0);
    const ChunkRange range = RangeOf(chunk, rows_.size());
    for (std::size_t b = range.first; b < range.end; ++b) {
      const std::size_t size = sizes_[b];
      const std::size_t offset = offsets_[b];
      const Row& row = rows_[b];
      std::array<double, kStride> own{}, sums{};
      std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(offset), size, own.begin());
      std::copy_n(part.begin() + static_cast<std::ptrdiff_t>(offset), size, sums.begin());
      for (std::size_t k = 0; k < row.columns.size(); ++k) {
        const double* cells = row.cells.data() + k * size * kStride;
        const auto column = static_cast<std::size_t>(row.columns[k]);
        const double* of_other = x.data() + offsets_[column];
        double* to_other = k > 0 ? part.data() + offsets_[column] : nullptr;
        switch (sizes_[column]) {
          case 1:
            MultiplyCell<1>(cells, size, own, of_other, sums, to_other);
            break;
          case 2:
            MultiplyCell<2>(cells, size, own, of_other, sums, to_other);
            break;
          default:
            MultiplyCell<3>(cells, size, own, of_other, sums, to_other);
        }
      }
      for (std::size_t p = 0; p < size; ++p) {
        part[offset + p] = sums[p];
      }
    }
  });
  y.assign(x.size(), 0.0);
  renderer::ParallelFor(kChunks, [&](std::int64_t chunk) {
    const ChunkRange range = RangeOf(chunk, x.size());
    for (const std::vector<double>& part : parts) {
      for (std::size_t i = range.first; i < range.end; ++i) {
        y[i] += part[i];
      }
    }
  });
}

std::size_t SparseGram::NumSeen() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(rows_, [](const Row& row) { return row.columns.size() > 1; }));
}

std::size_t SparseGram::MemoryBytes() const {
  std::size_t bytes = 0;
  for (const Row& row : rows_) {
    bytes += row.columns.capacity() * sizeof(std::int32_t) + row.cells.capacity() * sizeof(double) +
             (row.noise == nullptr ? 0 : sizeof(Noise));
  }
  return bytes;
}

std::size_t SparseGram::BytesOfEmpty(const ParameterSet& set) {
  const PairedBlocks paired(set);
  const std::size_t spread = paired.NumSpreadScalars() > 0 ? set.NumScalars() : 0;
  return paired.NumBlocks() * (sizeof(Row) + sizeof(sizes_[0]) + sizeof(offsets_[0])) +
         spread * sizeof(spread_diagonal_[0]);
}

}  // namespace pathfit::optim
