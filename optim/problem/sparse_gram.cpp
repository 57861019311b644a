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

Incidences SortByBlock(const PixelRows& rows, std::size_t num_blocks) {
  Incidences sorted;
  sorted.first.assign(num_blocks + 1, 0);
  for (const RowEntry& entry : rows.entries) {
    ++sorted.first[static_cast<std::size_t>(entry.block) + 1];
  }
  for (std::size_t b = 0; b < num_blocks; ++b) {
    sorted.first[b + 1] += sorted.first[b];
  }
  sorted.list.resize(rows.entries.size());
  std::vector<std::size_t> next(sorted.first.begin(), sorted.first.end() - 1);
  for (std::size_t u = 0; u < rows.units.size(); ++u) {
    const RowUnit& unit = rows.units[u];
    for (std::size_t e = 0; e < static_cast<std::size_t>(unit.num_entries); ++e) {
      const std::size_t index = unit.first_entry + e;
      sorted.list[next[static_cast<std::size_t>(rows.entries[index].block)]++] = {
          static_cast<std::uint32_t>(u), static_cast<std::uint32_t>(index)};
    }
  }
  return sorted;
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

SparseGram::SparseGram(const ParameterSet& set)
    : set_(&set), rows_(set.NumBlocks()), noise_(set.NumBlocks()) {
  for (std::size_t b = 0; b < rows_.size(); ++b) {
    const auto block = static_cast<std::int32_t>(b);
    Append(block, static_cast<std::size_t>(set.BlockSize(block)) * kStride, rows_[b]);
  }
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

void SparseGram::Add(const PixelRows& rows) {
  const Incidences sorted = SortByBlock(rows, rows_.size());
  renderer::ParallelFor(kChunks, [&](std::int64_t chunk) {
    std::vector<std::int32_t> position(rows_.size(), -1);  // of a column in the row
    const ChunkRange range = RangeOf(chunk, rows_.size());
    for (std::size_t b = range.first; b < range.end; ++b) {
      if (sorted.first[b] == sorted.first[b + 1]) {
        continue;
      }
      Row& row = rows_[b];
      const auto size = static_cast<std::size_t>(set_->BlockSize(static_cast<std::int32_t>(b)));
      const std::size_t num_cells = size * kStride;
      for (std::size_t k = 0; k < row.columns.size(); ++k) {
        position[static_cast<std::size_t>(row.columns[k])] = static_cast<std::int32_t>(k);
      }
      for (std::size_t i = sorted.first[b]; i < sorted.first[b + 1]; ++i) {
        const RowUnit& unit = rows.units[sorted.list[i].unit];
        const auto num_rows = static_cast<std::size_t>(unit.NumRows());
        const RowEntry& own = rows.entries[sorted.list[i].entry];
        const std::size_t end = unit.first_entry + static_cast<std::size_t>(unit.num_entries);
        if (!rows.spreads.empty()) {
          const EntrySpread& spread = rows.spreads[sorted.list[i].entry];
          for (std::size_t p = 0; p < size; ++p) {
            const auto of_gradient = static_cast<double>(spread.gradient[p]);
            noise_[b].gradient[p] += of_gradient * of_gradient;
          }
          for (std::size_t r = 0; r < num_rows; ++r) {
            for (std::size_t p = 0; p < size; ++p) {
              for (std::size_t q = 0; q < size; ++q) {
                noise_[b].square[p * kStride + q] +=
                    static_cast<double>(spread.jacobian[r * size + p]) *
                    static_cast<double>(spread.jacobian[r * size + q]);
              }
            }
          }
        }
        for (std::size_t e = sorted.list[i].entry; e < end; ++e) {
          const RowEntry& other = rows.entries[e];
          auto& place = position[static_cast<std::size_t>(other.block)];
          if (place < 0) {
            place = static_cast<std::int32_t>(Append(other.block, num_cells, row));
          }
          double* cells = row.cells.data() + static_cast<std::size_t>(place) * num_cells;
          const auto width = static_cast<std::size_t>(set_->BlockSize(other.block));
          for (std::size_t r = 0; r < num_rows; ++r) {
            for (std::size_t p = 0; p < size; ++p) {
              const auto left = static_cast<double>(own.jacobian[r * size + p]);
              if (left == 0.0) {
                continue;  // colours and lights act on a channel each
              }
              for (std::size_t q = 0; q < width; ++q) {
                cells[p * kStride + q] += left * static_cast<double>(other.jacobian[r * width + q]);
              }
            }
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
  std::vector<Eigen::Matrix3d> scales(rows_.size());
  renderer::ParallelFor(kChunks, [&](std::int64_t chunk) {
    const ChunkRange range = RangeOf(chunk, rows_.size());
    for (std::size_t b = range.first; b < range.end; ++b) {
      const auto block = static_cast<std::int32_t>(b);
      const auto size = static_cast<std::size_t>(set_->BlockSize(block));
      double squares = 0.0;  // of the gradient in its standard deviations
      for (std::size_t p = 0; p < size; ++p) {
        const double g = gradient[set_->BlockOffset(block) + p];
        squares += g == 0.0 ? 0.0 : g * g / noise_[b].gradient[p];
      }
      // As means are shrunk by their noise [James and Stein 1961].
      const double share = std::max(0.0, 1.0 - static_cast<double>(size) / squares);
      scales[b] =
          ScaleWithout(share, noise_[b].square, rows_[b].cells, static_cast<Eigen::Index>(size));
    }
  });
  renderer::ParallelFor(kChunks, [&](std::int64_t chunk) {
    const ChunkRange range = RangeOf(chunk, rows_.size());
    for (std::size_t b = range.first; b < range.end; ++b) {
      Row& row = rows_[b];
      const auto size = static_cast<Eigen::Index>(set_->BlockSize(static_cast<std::int32_t>(b)));
      for (std::size_t k = 0; k < row.columns.size(); ++k) {
        const auto width = static_cast<Eigen::Index>(set_->BlockSize(row.columns[k]));
        CellMap cell(row.cells.data() + k * static_cast<std::size_t>(size) * kStride,
                     size,
                     width,
                     Eigen::OuterStride<>(kStride));
        const auto& right = scales[static_cast<std::size_t>(row.columns[k])];
        cell = (scales[b].topLeftCorner(size, size) * cell *
                right.topLeftCorner(width, width).transpose())
                   .eval();
      }
    }
  });
}

void SparseGram::Add(std::int32_t row_block,
                     std::int32_t column_block,
                     std::span<const double> product) {
  PATHFIT_DCHECK(row_block <= column_block);
  Row& row = rows_[static_cast<std::size_t>(row_block)];
  const auto size = static_cast<std::size_t>(set_->BlockSize(row_block));
  const auto width = static_cast<std::size_t>(set_->BlockSize(column_block));
  const auto found = std::ranges::find(row.columns, column_block);
  const std::size_t place = found != row.columns.end()
                                ? static_cast<std::size_t>(found - row.columns.begin())
                                : Append(column_block, size * kStride, row);
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
      const auto block = static_cast<std::int32_t>(b);
      const auto size = static_cast<std::size_t>(set_->BlockSize(block));
      const std::size_t offset = set_->BlockOffset(block);
      const Row& row = rows_[b];
      for (std::size_t k = 0; k < row.columns.size(); ++k) {
        const double* cells = row.cells.data() + k * size * kStride;
        const auto width = static_cast<std::size_t>(set_->BlockSize(row.columns[k]));
        const std::size_t other = set_->BlockOffset(row.columns[k]);
        for (std::size_t p = 0; p < size; ++p) {
          for (std::size_t q = 0; q < width; ++q) {
            const double cell = cells[p * kStride + q];
            part[offset + p] += cell * x[other + q];
            if (k > 0) {
              part[other + q] += cell * x[offset + p];
            }
          }
        }
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
  std::size_t bytes = rows_.capacity() * sizeof(Row) + noise_.capacity() * sizeof(noise_[0]);
  for (const Row& row : rows_) {
    bytes += row.columns.capacity() * sizeof(std::int32_t) + row.cells.capacity() * sizeof(double);
  }
  return bytes;
}

}  // namespace pathfit::optim
