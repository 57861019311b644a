#include "optim/problem/support_roots.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "optim/problem/shares.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/core/process_memory.h"

namespace pathfit::optim {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using RowMajorFloats = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Blocks = std::vector<std::int32_t>;

// Groups of at most so many scalars together are shared: their normal equations are kept densely.
constexpr std::int64_t kMaxSharedScalars = 1000;
// A support joins another one if that takes at most this share of what it takes alone: with 1,
// supports would grow until they are as large in the mean as those they save.
constexpr double kJoinShare = 0.5;
// Supports with more than this share of their columns in common are seen again in other views.
constexpr double kNearShare = 0.5;
// The solver's cells of a root, in panels, over those of its trapezoid.
constexpr double kPanelWaste = 1.2;
constexpr std::size_t kPanelRows = 16;
// Memory of a residual block and of each of its pointers, in cells (of 4 and 8 bytes).
constexpr double kCellsPerPanel = 50.0;
constexpr double kCellsPerBlock = 4.0;
// Of a block's supports, newest first, so many are looked at: where far couplings make more,
// neither containing nor joining pays.
constexpr std::size_t kMaxScanned = 512;
constexpr std::size_t kMaxCandidates = 64;
constexpr std::size_t kBatch = 128;         // supports at a time, for those of shared blocks
constexpr std::size_t kUnitsAtOnce = 64;    // whose rows are multiplied together
constexpr double kDeflationShift = 1e-6;    // of a column's square
constexpr std::size_t kMostDeflated = 200;  // columns: the work grows with their cube
constexpr double kRelativeShift = 1e-9;     // of a column's square: makes the root exist

/// `= {}` would keep the memory.
template <class T>
void Free(std::vector<T>& values) {
  values = std::vector<T>();
}

std::span<const RowEntry> EntriesOf(const PixelRows& rows, const RowUnit& unit) {
  return std::span(rows.entries)
      .subspan(unit.first_entry, static_cast<std::size_t>(unit.num_entries));
}

/// Units of one set of blocks stand side by side; otherwise in their own order.
std::vector<std::size_t> SortBySupport(const PixelRows& rows) {
  std::vector<std::size_t> order(rows.units.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto by_block = [](const RowEntry& a, const RowEntry& b) { return a.block < b.block; };
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    const auto ea = EntriesOf(rows, rows.units[a]);
    const auto eb = EntriesOf(rows, rows.units[b]);
    return std::lexicographical_compare(ea.begin(), ea.end(), eb.begin(), eb.end(), by_block);
  });
  return order;
}

bool SameSupport(const PixelRows& rows, const RowUnit& a, const RowUnit& b) {
  return std::ranges::equal(EntriesOf(rows, a),
                            EntriesOf(rows, b),
                            [](const auto& x, const auto& y) { return x.block == y.block; });
}

std::span<const std::int32_t> LocalBlocks(const Support& support) {
  return std::span(support.blocks).first(support.num_local);
}
std::span<const std::int32_t> SharedBlocks(const Support& support) {
  return std::span(support.blocks).subspan(support.num_local);
}

Blocks Union(std::span<const std::int32_t> a, std::span<const std::int32_t> b) {
  Blocks both;
  std::ranges::set_union(a, b, std::back_inserter(both));
  return both;
}

/// Cells of a root's trapezoid.
std::size_t NumRootCells(const Support& support) {
  const std::size_t rows = support.num_local_columns;
  return rows * support.num_columns - rows * (rows == 0 ? 0 : rows - 1) / 2;
}

std::size_t NumInflationCells(const Support& support) {
  return support.num_local_columns * (support.num_local_columns + 1) / 2;
}

/// The upper triangle of rows^T rows.
Eigen::MatrixXd UpperProduct(const RowMajorMatrix& rows) {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(rows.cols(), rows.cols());
  if (rows.size() > 0) {  // Eigen divides by the number of rows
    product.selfadjointView<Eigen::Upper>().rankUpdate(rows.transpose());
  }
  return product;
}

double RootCells(double num_local_columns, double num_columns) {
  return num_local_columns * (num_columns - 0.5 * (num_local_columns - 1.0));
}

double CellsOf(double rows, double num_local_columns, double num_columns, double num_blocks) {
  return std::min(rows * num_columns, kPanelWaste * RootCells(num_local_columns, num_columns)) +
         kCellsPerPanel + kCellsPerBlock * num_blocks;
}

}  // namespace

/// Units of one set of blocks: order[first .. end).
struct SupportRoots::Range {
  std::size_t first = 0, end = 0;
  Blocks local, shared;
  std::int64_t num_rows = 0;
  double noise_squared = 0.0;

  /// Of kUnitsAtOnce units from the `from`-th on.
  [[nodiscard]] DenseRows Gather(const PixelRows& rows,
                                 const std::vector<std::size_t>& order,
                                 std::size_t from,
                                 const ParameterSet& set) const;
};

/// Rows of one support with its columns, local ones first.
struct SupportRoots::DenseRows {
  RowMajorMatrix cells;
  RowMajorMatrix spreads;  ///< of local columns
  Eigen::VectorXd residual;
  Eigen::VectorXd noise;  ///< by column, of all rows
};

/// A support that gets rows, and what it was before.
struct SupportRoots::Touched {
  std::int32_t support = 0;
  Blocks old_blocks;
  std::size_t old_num_local = 0;
  std::vector<Range> ranges;
};

/// Rows by shared blocks.
struct SupportRoots::SharedRows {
  Blocks blocks;
  RowMajorMatrix cells;
  Eigen::VectorXd residual;
};

SupportRoots::DenseRows SupportRoots::Range::Gather(const PixelRows& rows,
                                                    const std::vector<std::size_t>& order,
                                                    std::size_t from,
                                                    const ParameterSet& set) const {
  const std::size_t to = std::min(end, from + kUnitsAtOnce);
  Eigen::Index height = 0, num_columns = 0;
  for (std::size_t k = from; k < to; ++k) {
    height += rows.units[order[k]].NumRows();
  }
  std::vector<Eigen::Index> first_column;  // by entry
  for (const Blocks* blocks : {&local, &shared}) {
    for (const std::int32_t block : *blocks) {
      const auto entries = EntriesOf(rows, rows.units[order[first]]);
      first_column.resize(entries.size());
      const auto entry = std::ranges::lower_bound(entries, block, {}, &RowEntry::block);
      first_column[static_cast<std::size_t>(entry - entries.begin())] = num_columns;
      num_columns += set.BlockSize(block);
    }
  }
  Eigen::Index num_local_columns = 0;
  for (const std::int32_t block : local) {
    num_local_columns += rows.spreads.empty() ? 0 : set.BlockSize(block);
  }
  DenseRows dense{RowMajorMatrix(height, num_columns),
                  RowMajorMatrix(height, num_local_columns),
                  Eigen::VectorXd(height),
                  Eigen::VectorXd::Zero(num_columns)};
  Eigen::Index row = 0;
  for (std::size_t k = from; k < to; ++k) {
    const RowUnit& unit = rows.units[order[k]];
    const auto entries = EntriesOf(rows, unit);
    for (std::size_t e = 0; e < entries.size(); ++e) {
      const int size = set.BlockSize(entries[e].block);
      for (int c = 0; c < size; ++c) {
        const Eigen::Index column = first_column[e] + c;
        for (int r = 0; r < unit.NumRows(); ++r) {
          const auto cell = static_cast<std::size_t>(r * size + c);
          dense.cells(row + r, column) = static_cast<double>(entries[e].jacobian[cell]);
          if (column < num_local_columns) {
            dense.spreads(row + r, column) =
                static_cast<double>(rows.spreads[unit.first_entry + e].jacobian[cell]);
          }
        }
        dense.noise(column) -= static_cast<double>(entries[e].noise[static_cast<std::size_t>(c)]);
      }
    }
    for (int r = 0; r < unit.NumRows(); ++r) {
      dense.residual(row++) = unit.residual[static_cast<std::size_t>(r)];
    }
  }
  return dense;
}

SupportRoots::SupportRoots(const ParameterSet& set, std::size_t num_views)
    : set_(set),
      num_views_(num_views),
      is_shared_(set.NumBlocks()),
      shared_column_(set.NumBlocks()),
      supports_(1),
      supports_of_block_(set.NumBlocks()) {
  std::vector<const renderer::ParameterGroup*> groups;
  for (const renderer::ParameterGroup& group : set.layout().groups()) {
    if (!renderer::TraitsOf(group.kind).of_surface) {
      groups.push_back(&group);
    }
  }
  std::ranges::stable_sort(
      groups, [](const auto* a, const auto* b) { return a->NumScalars() < b->NumScalars(); });
  std::int64_t num_shared = 0;
  for (const renderer::ParameterGroup* group : groups) {
    num_shared += static_cast<std::int64_t>(group->NumScalars());
    if (num_shared > kMaxSharedScalars) {
      break;
    }
    for (std::int32_t block = 0; block < group->num_blocks; ++block) {
      is_shared_[static_cast<std::size_t>(group->first_block + block)] = 1;
    }
  }
  Support& shared = supports_[0];
  shared.is_root = true;
  for (std::size_t block = 0; block < is_shared_.size(); ++block) {
    if (is_shared_[block] != 0) {
      shared.blocks.push_back(static_cast<std::int32_t>(block));
      shared_column_[block] = shared.num_columns;
      shared.num_columns += Columns(shared.blocks.back());
    }
  }
  shared.num_local = shared.blocks.size();
  shared.num_local_columns = shared.num_columns;
  shared.matrix.resize(shared.num_columns * (shared.num_columns + 1) / 2);
  shared.gradient.resize(shared.num_columns);
  shared.noise.resize(shared.num_columns);
}

double SupportRoots::ExpectedGrowth() const {
  return static_cast<double>(std::max(num_views_, view_)) /
         static_cast<double>(std::max<std::size_t>(1, view_));
}

/// Finds the support that rows go to, one set of blocks after the other.
class SupportRoots::Assigner {
 public:
  explicit Assigner(SupportRoots& roots)
      : roots_(roots), growth_(roots.ExpectedGrowth()), touched_of_(roots.supports_.size(), -1) {}

  void Assign(Range range) {
    const auto num_rows = static_cast<double>(range.num_rows);
    std::int32_t id = FindContaining(range, num_rows);
    if (id < 0) {
      id = FindToJoin(range, num_rows);
    }
    if (id < 0) {
      id = static_cast<std::int32_t>(roots_.supports_.size());
      roots_.supports_.emplace_back();
      touched_of_.push_back(-1);
    }
    auto& index = touched_of_[static_cast<std::size_t>(id)];
    Support& support = roots_.supports_[static_cast<std::size_t>(id)];
    if (index < 0) {
      index = static_cast<std::int32_t>(touched.size());
      touched.push_back({id, support.blocks, support.num_local, {}});
    }
    Grow(id, range, support);
    support.num_rows += range.num_rows;
    support.noise_squared += range.noise_squared;
    touched[static_cast<std::size_t>(index)].ranges.push_back(std::move(range));
  }

  std::vector<Touched> touched;

 private:
  [[nodiscard]] const std::vector<std::int32_t>& ListOf(std::int32_t block) const {
    return roots_.supports_of_block_[static_cast<std::size_t>(block)];
  }

  /// The smallest that holds all blocks, unless few rows become a root by it that is larger than
  /// one of these blocks alone.
  [[nodiscard]] std::int32_t FindContaining(const Range& range, double num_rows) const {
    const auto& list = ListOf(*std::ranges::min_element(
        range.local, {}, [&](std::int32_t block) { return ListOf(block).size(); }));
    double columns = 0.0;
    for (const std::int32_t block : range.local) {
      columns += static_cast<double>(roots_.Columns(block));
    }
    const double alone =
        CellsOf(growth_ * num_rows, columns, columns, static_cast<double>(range.local.size()));
    const std::size_t first = list.size() > kMaxScanned ? list.size() - kMaxScanned : 0;
    std::int32_t best = -1;
    std::size_t least = std::numeric_limits<std::size_t>::max();
    for (std::size_t i = list.size(); i-- > first;) {
      const Support& support = roots_.supports_[static_cast<std::size_t>(list[i])];
      if (support.num_local < range.local.size() || support.num_local_columns > least ||
          !std::ranges::includes(LocalBlocks(support), range.local)) {
        continue;
      }
      const auto local = static_cast<double>(support.num_local_columns);
      const auto rows = static_cast<double>(support.num_rows);
      if (support.is_root || CellsOf(rows + growth_ * num_rows, local, local, 0.0) -
                                     CellsOf(rows, local, local, 0.0) <=
                                 alone) {
        best = list[i];
        least = support.num_local_columns;
      }
    }
    return best;
  }

  std::int32_t FindToJoin(const Range& range, double num_rows) {
    overlap_.resize(roots_.supports_.size());
    candidates_.clear();
    double local = 0.0, shared = 0.0;
    for (const std::int32_t block : range.local) {
      const auto& list = ListOf(block);
      local += static_cast<double>(roots_.Columns(block));
      const std::size_t first = list.size() > kMaxCandidates ? list.size() - kMaxCandidates : 0;
      for (std::size_t i = first; i < list.size(); ++i) {
        auto& overlap = overlap_[static_cast<std::size_t>(list[i])];
        if (overlap.columns == 0) {
          candidates_.push_back(list[i]);
        }
        overlap.columns += static_cast<int>(roots_.Columns(block));
        ++overlap.blocks;
      }
    }
    for (const std::int32_t block : range.shared) {
      shared += static_cast<double>(roots_.Columns(block));
    }
    const auto num_blocks = static_cast<double>(range.local.size() + range.shared.size());
    const auto alone = [&](double growth) {
      return kJoinShare * CellsOf(growth * num_rows, local, local + shared, num_blocks);
    };
    const double alone_now = alone(1.0), alone_at_end = alone(growth_);
    double most = 0.0;
    std::int32_t best = -1;
    for (const std::int32_t id : candidates_) {
      auto& overlap = overlap_[static_cast<std::size_t>(id)];
      const Support& s = roots_.supports_[static_cast<std::size_t>(id)];
      // What has little in common with what there is, as far couplings have, may not come again.
      const bool is_near = overlap.columns > kNearShare * local;
      const double growth = is_near ? growth_ : 1.0;
      const auto s_local = static_cast<double>(s.num_local_columns);
      const auto s_all = static_cast<double>(s.num_columns);
      const auto s_rows = growth * static_cast<double>(s.num_rows);
      const double joined = s_local + local - overlap.columns;
      const double joined_shared = std::max(shared, s_all - s_local);
      const double more =
          CellsOf(s_rows + growth * num_rows,
                  joined,
                  joined + joined_shared,
                  static_cast<double>(s.blocks.size()) + num_blocks - overlap.blocks) -
          CellsOf(s_rows, s_local, s_all, static_cast<double>(s.blocks.size()));
      const double saved = (is_near ? alone_at_end : alone_now) - more;
      if (saved > most || (saved == most && best >= 0 && id < best)) {
        most = saved;
        best = id;
      }
      overlap = {};
    }
    return best;
  }

  void Grow(std::int32_t id, const Range& range, Support& support) {
    if (std::ranges::includes(LocalBlocks(support), range.local) &&
        std::ranges::includes(SharedBlocks(support), range.shared)) {
      return;
    }
    for (const std::int32_t block : range.local) {
      if (!std::ranges::binary_search(LocalBlocks(support), block)) {
        auto& list = roots_.supports_of_block_[static_cast<std::size_t>(block)];
        list.insert(std::ranges::lower_bound(list, id), id);
      }
    }
    Blocks blocks = Union(LocalBlocks(support), range.local);
    const Blocks shared = Union(SharedBlocks(support), range.shared);
    support.num_local = blocks.size();
    blocks.insert(blocks.end(), shared.begin(), shared.end());
    support.blocks = std::move(blocks);
    support.num_columns = support.num_local_columns = 0;
    for (std::size_t k = 0; k < support.blocks.size(); ++k) {
      const std::size_t columns = roots_.Columns(support.blocks[k]);
      support.num_columns += columns;
      support.num_local_columns += k < support.num_local ? columns : 0;
    }
  }

  struct Overlap {
    int columns = 0, blocks = 0;
  };

  SupportRoots& roots_;
  double growth_;
  std::vector<std::int32_t> touched_of_;
  std::vector<Overlap> overlap_;
  std::vector<std::int32_t> candidates_;
};

std::vector<std::size_t> SupportRoots::ColumnsIn(const Support& support,
                                                 const Blocks& blocks) const {
  std::vector<std::size_t> columns;
  std::size_t k = 0, column = 0;
  for (const std::int32_t block : blocks) {
    for (; support.blocks[k] != block; ++k) {
      column += Columns(support.blocks[k]);
    }
    for (std::size_t c = 0; c < Columns(block); ++c) {
      columns.push_back(column + c);
    }
  }
  return columns;
}

void SupportRoots::Add(const PixelRows& rows) {
  const std::vector<std::size_t> order = SortBySupport(rows);
  Assigner assigner(*this);
  std::vector<Range> ranges, only_shared;
  for (std::size_t first = 0, end = 0; first < order.size(); first = end) {
    Range range;
    range.first = first;
    const RowUnit& unit = rows.units[order[first]];
    for (const RowEntry& entry : EntriesOf(rows, unit)) {
      (is_shared_[static_cast<std::size_t>(entry.block)] != 0 ? range.shared : range.local)
          .push_back(entry.block);
    }
    std::int64_t num_rows = 0;
    double noise_squared = 0.0;
    for (end = first; end < order.size() && SameSupport(rows, unit, rows.units[order[end]]);
         ++end) {
      const RowUnit& same = rows.units[order[end]];
      num_rows += same.NumRows();
      noise_squared += same.NoiseSquared();
      for (const double u : same.residual) {
        signal_squared_ += u * u;
      }
      for (const RowEntry& entry : EntriesOf(rows, same)) {
        const auto block = static_cast<std::size_t>(entry.block);
        for (std::size_t c = 0; is_shared_[block] != 0 && c < Columns(entry.block); ++c) {
          supports_[0].noise[shared_column_[block] + c] -= static_cast<double>(entry.noise[c]);
        }
      }
    }
    range.end = end;
    num_rows_ += static_cast<double>(num_rows);
    noise_squared_ += noise_squared;
    if (!range.shared.empty()) {
      supports_[0].num_rows += num_rows;
      supports_[0].noise_squared += noise_squared;
    }
    if (range.local.empty()) {
      only_shared.push_back(std::move(range));
    } else {
      range.num_rows = num_rows;
      range.noise_squared = noise_squared;
      ranges.push_back(std::move(range));
    }
  }
  // Small ones first: they need not stay in what far couplings have made.
  std::ranges::stable_sort(ranges, {}, [](const Range& range) { return range.local.size(); });
  for (Range& range : ranges) {
    assigner.Assign(std::move(range));
  }
  ForBatches(only_shared.size(), 1.0, [&](std::size_t i, std::vector<SharedRows>& out) {
    const Range& range = only_shared[i];
    for (std::size_t first = range.first; first < range.end; first += kUnitsAtOnce) {
      DenseRows dense = range.Gather(rows, order, first, set_);
      out.push_back({range.shared, std::move(dense.cells), std::move(dense.residual)});
    }
  });
  ForBatches(assigner.touched.size(), 1.0, [&](std::size_t i, std::vector<SharedRows>& out) {
    Fill(rows, order, assigner.touched[i], out);
  });
}

void SupportRoots::ForBatches(
    std::size_t count,
    double sign,
    const std::function<void(std::size_t, std::vector<SharedRows>&)>& body) {
  for (std::size_t first = 0; first < count; first += kBatch) {
    const std::size_t size = std::min(kBatch, count - first);
    std::vector<std::vector<SharedRows>> parts(size);
    renderer::ParallelFor(static_cast<std::int64_t>(size), [&](std::int64_t i) {
      const auto k = static_cast<std::size_t>(i);
      body(first + k, parts[k]);
    });
    AddShared(parts, sign);
  }
}

void SupportRoots::AddShared(const std::vector<std::vector<SharedRows>>& parts, double sign) {
  std::vector<const SharedRows*> all;
  for (const std::vector<SharedRows>& part : parts) {
    for (const SharedRows& rows : part) {
      all.push_back(&rows);
    }
  }
  std::vector<Eigen::MatrixXd> products(all.size());
  renderer::ParallelFor(static_cast<std::int64_t>(all.size()), [&](std::int64_t i) {
    const auto k = static_cast<std::size_t>(i);
    products[k] = UpperProduct(all[k]->cells);
  });
  Support& shared = supports_[0];
  for (std::size_t k = 0; k < all.size(); ++k) {
    const std::vector<std::size_t> columns = ColumnsIn(shared, all[k]->blocks);
    const Eigen::VectorXd gradient = all[k]->cells.transpose() * all[k]->residual;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      shared.gradient[columns[i]] += sign * gradient(row);
      double* target = shared.matrix.data() + shared.RowOffset(columns[i]);
      for (std::size_t j = i; j < columns.size(); ++j) {
        target[columns[j]] += sign * products[k](row, static_cast<Eigen::Index>(j));
      }
    }
  }
}

void SupportRoots::Widen(const Touched& touched, Support& support) const {
  if (touched.old_blocks.size() == support.blocks.size()) {
    return;
  }
  const std::vector<std::size_t> to = ColumnsIn(support, touched.old_blocks);
  Support old;
  old.is_root = support.is_root;
  old.num_columns = to.size();
  for (std::size_t k = 0; k < touched.old_num_local; ++k) {
    old.num_local_columns += Columns(touched.old_blocks[k]);
  }
  old.residual.swap(support.residual);
  old.noise.swap(support.noise);
  old.gradient.swap(support.gradient);
  old.rows.swap(support.rows);
  old.matrix.swap(support.matrix);
  old.spreads.swap(support.spreads);
  old.inflation.swap(support.inflation);
  support.noise.assign(support.num_local_columns, 0.0);
  for (std::size_t i = 0; i < old.noise.size(); ++i) {
    support.noise[to[i]] = old.noise[i];
  }
  if (!support.is_root) {
    support.residual.swap(old.residual);
    support.rows.assign(support.residual.size() * support.num_columns, 0.0F);
    for (std::size_t i = 0; i < support.residual.size(); ++i) {
      for (std::size_t j = 0; j < to.size(); ++j) {
        support.rows[support.RowOffset(i) + to[j]] = old.rows[old.RowOffset(i) + j];
      }
    }
    support.spreads.assign(support.residual.size() * support.num_local_columns, 0.0F);
    for (std::size_t i = 0; i < support.residual.size(); ++i) {
      for (std::size_t j = 0; j < old.num_local_columns; ++j) {
        support.spreads[i * support.num_local_columns + to[j]] =
            old.spreads[i * old.num_local_columns + j];
      }
    }
    return;
  }
  support.gradient.assign(support.num_local_columns, 0.0);
  support.matrix.assign(NumRootCells(support), 0.0);
  support.inflation.assign(NumInflationCells(support), 0.0F);
  for (std::size_t i = 0; i < old.num_local_columns; ++i) {
    for (std::size_t j = i; j < old.num_local_columns; ++j) {
      support.inflation[support.InflationCell(to[i], to[j])] =
          old.inflation[old.InflationCell(i, j)];
    }
    support.gradient[to[i]] = old.gradient[i];
    for (std::size_t j = i; j < to.size(); ++j) {
      support.matrix[support.RowOffset(to[i]) + to[j]] = old.matrix[old.RowOffset(i) + j];
    }
  }
}

void SupportRoots::AddToRoot(DenseRows dense,
                             const std::vector<std::size_t>& columns,
                             const Blocks& shared_blocks,
                             Support& support,
                             std::vector<SharedRows>& shared) const {
  const Eigen::MatrixXd product = UpperProduct(dense.cells);
  const Eigen::VectorXd gradient = dense.cells.transpose() * dense.residual;
  std::size_t num_local = 0;
  for (; num_local < columns.size() && columns[num_local] < support.num_local_columns;
       ++num_local) {
    const auto i = static_cast<Eigen::Index>(num_local);
    support.gradient[columns[num_local]] += gradient(i);
    double* target = support.matrix.data() + support.RowOffset(columns[num_local]);
    for (std::size_t j = num_local; j < columns.size(); ++j) {
      target[columns[j]] += product(i, static_cast<Eigen::Index>(j));
    }
  }
  const Eigen::MatrixXd inflation = UpperProduct(dense.spreads);
  for (std::size_t i = 0; i < static_cast<std::size_t>(inflation.cols()); ++i) {
    for (std::size_t j = i; j < num_local; ++j) {
      support.inflation[support.InflationCell(columns[i], columns[j])] +=
          static_cast<float>(inflation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
    }
  }
  if (!shared_blocks.empty()) {
    const auto first = static_cast<Eigen::Index>(num_local);
    shared.push_back({shared_blocks,
                      dense.cells.rightCols(dense.cells.cols() - first),
                      std::move(dense.residual)});
  }
}

void SupportRoots::MakeRoot(Support& support, std::vector<SharedRows>& shared) const {
  const auto num_rows = static_cast<Eigen::Index>(support.residual.size());
  const auto num_columns = static_cast<Eigen::Index>(support.num_columns);
  DenseRows dense;
  dense.cells =
      Eigen::Map<const RowMajorFloats>(support.rows.data(), num_rows, num_columns).cast<double>();
  dense.spreads =
      Eigen::Map<const RowMajorFloats>(
          support.spreads.data(), num_rows, static_cast<Eigen::Index>(support.num_local_columns))
          .cast<double>();
  dense.residual = Eigen::Map<const Eigen::VectorXd>(support.residual.data(), num_rows);
  support.is_root = true;
  Free(support.rows);
  Free(support.spreads);
  support.inflation.assign(NumInflationCells(support), 0.0F);
  Free(support.residual);
  support.gradient.assign(support.num_local_columns, 0.0);
  support.matrix.assign(NumRootCells(support), 0.0);
  std::vector<std::size_t> columns(support.num_columns);
  std::iota(columns.begin(), columns.end(), std::size_t{0});
  const auto shared_blocks = SharedBlocks(support);
  AddToRoot(
      std::move(dense), columns, {shared_blocks.begin(), shared_blocks.end()}, support, shared);
}

void SupportRoots::Fill(const PixelRows& rows,
                        const std::vector<std::size_t>& order,
                        const Touched& touched,
                        std::vector<SharedRows>& shared) {
  Support& support = supports_[static_cast<std::size_t>(touched.support)];
  Widen(touched, support);
  if (!support.is_root) {
    std::size_t num_rows = support.residual.size();
    for (const Range& range : touched.ranges) {
      for (std::size_t k = range.first; k < range.end; ++k) {
        num_rows += static_cast<std::size_t>(rows.units[order[k]].NumRows());
      }
    }
    // A root is gathered in numbers of twice the size.
    if (num_rows * support.num_columns > 2 * NumRootCells(support)) {
      MakeRoot(support, shared);
    }
  }
  for (const Range& range : touched.ranges) {
    Blocks blocks = range.local;
    blocks.insert(blocks.end(), range.shared.begin(), range.shared.end());
    const std::vector<std::size_t> columns = ColumnsIn(support, blocks);
    for (std::size_t first = range.first; first < range.end; first += kUnitsAtOnce) {
      DenseRows dense = range.Gather(rows, order, first, set_);
      for (std::size_t c = 0; c < columns.size() && columns[c] < support.num_local_columns; ++c) {
        support.noise[columns[c]] += dense.noise(static_cast<Eigen::Index>(c));
      }
      if (support.is_root) {
        AddToRoot(std::move(dense), columns, range.shared, support, shared);
        continue;
      }
      for (Eigen::Index row = 0; row < dense.cells.rows(); ++row) {
        const std::size_t offset = support.rows.size();
        support.rows.resize(offset + support.num_columns);
        for (std::size_t c = 0; c < columns.size(); ++c) {
          support.rows[offset + columns[c]] =
              static_cast<float>(dense.cells(row, static_cast<Eigen::Index>(c)));
        }
        const std::size_t spread = support.spreads.size();
        support.spreads.resize(spread + support.num_local_columns);
        for (Eigen::Index c = 0; c < dense.spreads.cols(); ++c) {
          support.spreads[spread + columns[static_cast<std::size_t>(c)]] =
              static_cast<float>(dense.spreads(row, c));
        }
        support.residual.push_back(dense.residual(row));
      }
    }
  }
  support.rows.shrink_to_fit();
  support.spreads.shrink_to_fit();
  support.residual.shrink_to_fit();
}

void SupportRoots::Deflate(Support& support) {
  if (std::ranges::all_of(support.inflation, [](float x) { return x == 0.0F; })) {
    return;
  }
  const std::size_t n = support.num_local_columns;
  const auto size = static_cast<Eigen::Index>(n);
  Eigen::MatrixXd square(size, size), inflation(size, size);
  Eigen::MatrixXd shared(size, static_cast<Eigen::Index>(support.num_columns - n));
  for (std::size_t i = 0; i < n; ++i) {
    const double* row = support.matrix.data() + support.RowOffset(i);
    for (std::size_t j = i; j < n; ++j) {
      const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
      square(a, b) = square(b, a) = row[j];
      inflation(a, b) = inflation(b, a) =
          static_cast<double>(support.inflation[support.InflationCell(i, j)]);
    }
    for (std::size_t j = n; j < support.num_columns; ++j) {
      shared(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j - n)) = row[j];
    }
  }
  // Scalars of very different sizes: in units of their own squares.
  const Eigen::VectorXd unit = square.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const Eigen::VectorXd inverse = unit.cwiseInverse();
  square = inverse.asDiagonal() * square * inverse.asDiagonal();
  inflation = inverse.asDiagonal() * inflation * inverse.asDiagonal();
  square.diagonal().array() += kDeflationShift;
  const std::optional<Shares> shares = SharesOf(inflation, square);
  if (!shares) {
    return;
  }
  const Eigen::VectorXd kept =
      (1.0 - shares->eigenvalues().array()).cwiseMax(kLeastTrueShare).cwiseMin(1.0);
  // With X the eigenvectors, square = dual dual^T and dual = square X.
  const Eigen::MatrixXd dual = unit.asDiagonal() * square * shares->eigenvectors();
  const Eigen::MatrixXd deflated = dual * kept.asDiagonal() * dual.transpose();
  // As if the rows of a root had been multiplied, so that no block loses more than it has.
  const Eigen::MatrixXd of_shared = dual * kept.cwiseSqrt().asDiagonal() *
                                    shares->eigenvectors().transpose() * inverse.asDiagonal() *
                                    shared;
  for (std::size_t i = 0; i < n; ++i) {
    double* row = support.matrix.data() + support.RowOffset(i);
    for (std::size_t j = i; j < n; ++j) {
      row[j] = deflated(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
    for (std::size_t j = n; j < support.num_columns; ++j) {
      row[j] = of_shared(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j - n));
    }
  }
}

void SupportRoots::Factor(Support& support, std::vector<SharedRows>& eliminated) const {
  if (support.num_local_columns <= kMostDeflated) {
    Deflate(support);
  }
  Free(support.inflation);
  const std::size_t num_rows = support.num_local_columns;
  const std::size_t num_columns = support.num_columns;
  const std::vector<double> gradient = support.gradient;
  support.residual.assign(num_rows, 0.0);
  for (std::size_t i = 0; i < num_rows; ++i) {
    double& square = support.matrix[support.RowOffset(i) + i];
    square *= 1.0 + kRelativeShift;
  }
  for (std::size_t i = 0; i < num_rows; ++i) {
    double* row = support.matrix.data() + support.RowOffset(i);
    if (!(row[i] > 0.0)) {
      std::fill(row + i, row + num_columns, 0.0);
      continue;
    }
    const double root = std::sqrt(row[i]);
    for (std::size_t j = i; j < num_columns; ++j) {
      row[j] /= root;
    }
    support.residual[i] = support.gradient[i] / root;
    for (std::size_t k = i + 1; k < num_rows; ++k) {
      const double factor = row[k];
      support.gradient[k] -= factor * support.residual[i];
      double* target = support.matrix.data() + support.RowOffset(k);
      for (std::size_t j = k; j < num_columns; ++j) {
        target[j] -= factor * row[j];
      }
    }
  }
  if (num_columns > num_rows) {
    const auto shared_blocks = SharedBlocks(support);
    SharedRows rows;
    rows.blocks.assign(shared_blocks.begin(), shared_blocks.end());
    rows.cells.resize(static_cast<Eigen::Index>(num_rows),
                      static_cast<Eigen::Index>(num_columns - num_rows));
    for (std::size_t i = 0; i < num_rows; ++i) {
      std::copy_n(support.matrix.data() + support.RowOffset(i) + num_rows,
                  num_columns - num_rows,
                  rows.cells.row(static_cast<Eigen::Index>(i)).data());
    }
    rows.residual = Eigen::Map<const Eigen::VectorXd>(support.residual.data(),
                                                      static_cast<Eigen::Index>(num_rows));
    eliminated.push_back(std::move(rows));
  }
  support.rows.assign(support.matrix.begin(), support.matrix.end());
  Free(support.matrix);
  Free(support.gradient);
  for (std::size_t j = 0; j < num_rows; ++j) {
    double sum = 0.0;
    for (std::size_t i = 0; i <= j; ++i) {
      sum += static_cast<double>(support.rows[support.RowOffset(i) + j]) * support.residual[i];
    }
    support.noise[j] += gradient[j] - sum;
  }
}

void SupportRoots::Finish() {
  // Rows that the solver holds in more cells than it would a root.
  const auto prefers_root = [&](const Support& support) {
    return !support.is_root && static_cast<double>(support.residual.size() * support.num_columns) >
                                   kPanelWaste * static_cast<double>(NumRootCells(support));
  };
  const std::size_t count = supports_.size() - 1;
  ForBatches(count, 1.0, [&](std::size_t i, std::vector<SharedRows>& shared) {
    if (prefers_root(supports_[i + 1])) {
      MakeRoot(supports_[i + 1], shared);
    }
  });
  ForBatches(count, -1.0, [&](std::size_t i, std::vector<SharedRows>& eliminated) {
    if (supports_[i + 1].is_root) {
      Factor(supports_[i + 1], eliminated);
    }
    Free(supports_[i + 1].spreads);
  });
  std::vector<SharedRows> none;
  Factor(supports_[0], none);
  const double rows = std::max(1.0, num_rows_);
  const double per_row = (noise_squared_ + kNoiseFloorShare * signal_squared_) / rows;
  for (std::size_t i = 0; i < supports_.size(); ++i) {
    Support& support = supports_[i];
    support.offset_squared = kNoiseRowFactor * (support.noise_squared +
                                                static_cast<double>(support.num_rows) * per_row) +
                             1e-12;
    AppendPanels(static_cast<std::int32_t>(i), support, support.is_root, panels_);
    if (support.num_columns == 0) {
      continue;
    }
    residual_squared_ += support.offset_squared;
    for (const double r : support.residual) {
      residual_squared_ += r * r;
    }
  }
  if (!std::isfinite(residual_squared_)) {
    throw renderer::NumericalError(
        "the squares of residuals or derivatives overflow; photos, lights and weights must be of "
        "ordinary size");
  }
  renderer::ReturnFreedMemory();  // what the roots were gathered in
}

void SupportRoots::AppendPanels(std::int32_t id,
                                const Support& support,
                                bool as_root,
                                std::vector<RootPanel>& panels) const {
  RootPanel panel;
  panel.support = id;
  panel.num_blocks = static_cast<std::int32_t>(support.blocks.size());
  panel.has_noise_row = true;
  if (!as_root) {
    panel.num_rows = static_cast<std::int32_t>(support.residual.size());
    panels.push_back(panel);
    return;
  }
  for (std::size_t k = 0; k < support.num_local; ++k) {
    const auto columns = static_cast<std::int32_t>(Columns(support.blocks[k]));
    panel.num_rows += columns;
    if (panel.num_rows < static_cast<std::int32_t>(kPanelRows) && k + 1 < support.num_local) {
      continue;
    }
    panels.push_back(panel);
    panel.has_noise_row = false;
    panel.first_row += panel.num_rows;
    panel.first_column = panel.first_row;
    panel.num_rows = 0;
    panel.first_block = static_cast<std::int32_t>(k + 1);
    panel.num_blocks = static_cast<std::int32_t>(support.blocks.size() - k - 1);
  }
}

RootSize SupportRoots::Size() const {
  RootSize size;
  // What the views so far do not show of a surface is like what they show.
  double num_local = 0.0, num_seen = 0.0;
  for (std::size_t block = 0; block < is_shared_.size(); ++block) {
    num_local += is_shared_[block] != 0 ? 0.0 : 1.0;
    num_seen += supports_of_block_[block].empty() ? 0.0 : 1.0;
  }
  const double growth = panels_.empty() ? ExpectedGrowth() : 1.0;
  std::vector<RootPanel> panels;
  for (const Support& support : supports_) {
    const auto num_rows = support.is_root ? std::numeric_limits<double>::infinity()
                                          : growth * static_cast<double>(support.residual.size());
    const auto num_columns = static_cast<double>(support.num_columns);
    const auto root = static_cast<double>(NumRootCells(support));
    const bool as_root = support.is_root || num_rows * num_columns > kPanelWaste * root;
    const auto columns = static_cast<double>(support.num_local_columns);
    size.gathered_bytes +=
        as_root ? 8.0 * root + 2.0 * columns * columns : 4.0 * num_rows * (num_columns + columns);
    size.kept_bytes += 4.0 * (as_root ? root : num_rows * num_columns);
    const double own = static_cast<double>(sizeof(Support)) + 12.0 * num_columns;
    size.gathered_bytes += own;
    size.kept_bytes += own;
    panels.clear();
    AppendPanels(0, support, as_root, panels);
    for (const RootPanel& panel : panels) {
      const double rows = (as_root ? static_cast<double>(panel.num_rows) : num_rows) +
                          (panel.has_noise_row ? 1 : 0);
      const double width = num_columns - static_cast<double>(panel.first_column);
      const auto blocks = static_cast<double>(panel.num_blocks);
      size.num_panels += 1.0;
      size.panel_blocks += blocks;
      size.jacobian_cells += rows * width;
      size.product_cells += 0.5 * blocks * (blocks + 1.0);
    }
  }
  if (panels_.empty() && view_ < num_views_ && num_seen > 0.0) {
    const double unseen = num_local / num_seen;
    for (double* figure : {&size.gathered_bytes,
                           &size.kept_bytes,
                           &size.num_panels,
                           &size.panel_blocks,
                           &size.jacobian_cells,
                           &size.product_cells}) {
      *figure *= unseen;
    }
  }
  return size;
}

}  // namespace pathfit::optim
