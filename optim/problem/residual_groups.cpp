#include "optim/problem/residual_groups.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <span>

#include "renderer/core/parallel.h"

namespace pathfit::optim {
namespace {

constexpr std::size_t kMaxUnitsPerGroup = 64;
constexpr double kOffsetFactor =
    1e4;  // C^2 over the noise seen: the noise row's share of J^T J is its inverse
constexpr double kOffsetFloorShare =
    1e-3;  // of the mean squared residual, for groups that saw no noise by luck

std::span<const RowEntry> EntriesOf(const PixelRows& rows, const RowUnit& unit) {
  return std::span(rows.entries)
      .subspan(unit.first_entry, static_cast<std::size_t>(unit.num_entries));
}

}  // namespace

struct ResidualGroups::Builder {
  const PixelRows& rows;
  const ParameterSet& set;
  ResidualGroups& out;
  std::vector<std::size_t> order;       // units sorted by block list
  std::vector<std::size_t> group_ends;  // into order
  std::vector<std::int32_t> joined{};   // blocks of the group under construction

  [[nodiscard]] std::size_t Columns(std::int32_t block) const {
    return static_cast<std::size_t>(set.BlockSize(block));
  }

  void SortUnits() {
    order.resize(rows.units.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto by_block = [](const RowEntry& a, const RowEntry& b) { return a.block < b.block; };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      const auto ea = EntriesOf(rows, rows.units[a]);
      const auto eb = EntriesOf(rows, rows.units[b]);
      return std::lexicographical_compare(ea.begin(), ea.end(), eb.begin(), eb.end(), by_block);
    });
  }

  // Joins neighbours in sorted order while hardly any zero is stored.
  void Partition() {
    std::size_t first = 0, nonzeros = 0, num_rows = 0;
    std::vector<std::int32_t> own, with_unit;
    for (std::size_t i = 0; i < order.size(); ++i) {
      const RowUnit& unit = rows.units[order[i]];
      own.clear();
      std::size_t columns = 0;
      for (const RowEntry& entry : EntriesOf(rows, unit)) {
        own.push_back(entry.block);
        columns += Columns(entry.block);
      }
      const auto unit_rows = static_cast<std::size_t>(unit.NumRows());
      with_unit.clear();
      std::set_union(
          joined.begin(), joined.end(), own.begin(), own.end(), std::back_inserter(with_unit));
      std::size_t joined_columns = 0;
      for (const std::int32_t block : with_unit) {
        joined_columns += Columns(block);
      }
      const auto cells = static_cast<double>((num_rows + unit_rows) * joined_columns);
      const auto dense = static_cast<double>(nonzeros + unit_rows * columns);
      const bool fits = cells <= kMaxFill * dense && i - first < kMaxUnitsPerGroup;
      if (i > first && !fits) {
        Close(first, i);
        first = i;
        nonzeros = num_rows = 0;
        with_unit = own;
      }
      joined.swap(with_unit);
      nonzeros += unit_rows * columns;
      num_rows += unit_rows;
    }
    if (first < order.size()) {
      Close(first, order.size());
    }
  }

  void Close(std::size_t first, std::size_t end) {
    ResidualGroup group;
    group.first_row = out.row_sources_.size();
    group.first_block = out.blocks_.size();
    group.first_cell = num_cells;
    group.num_blocks = static_cast<std::int32_t>(joined.size());
    for (std::size_t i = first; i < end; ++i) {
      const RowUnit& unit = rows.units[order[i]];
      for (int row = 0; row < unit.NumRows(); ++row) {
        out.row_sources_.push_back(std::int64_t{unit.pixel} * 4 + unit.Channel(row));
      }
      group.num_rows += unit.NumRows();
    }
    std::size_t columns = 0;
    for (const std::int32_t block : joined) {
      columns += Columns(block);
    }
    out.blocks_.insert(out.blocks_.end(), joined.begin(), joined.end());
    num_cells += static_cast<std::size_t>(group.num_rows + 1) * columns;
    out.groups_.push_back(group);
    group_ends.push_back(end);
    joined.clear();
  }

  void Fill() {
    out.cells_.assign(num_cells, 0.0F);
    renderer::ParallelFor(static_cast<std::int64_t>(out.groups_.size()),
                          [this](std::int64_t g) { FillGroup(static_cast<std::size_t>(g)); });
  }

  void FillGroup(std::size_t g) const {
    const ResidualGroup& group = out.groups_[g];
    const auto blocks = std::span(out.blocks_)
                            .subspan(group.first_block, static_cast<std::size_t>(group.num_blocks));
    std::vector<std::size_t> cell_of_block;
    std::size_t cell = group.first_cell;
    for (const std::int32_t block : blocks) {
      cell_of_block.push_back(cell);
      cell += static_cast<std::size_t>(group.num_rows + 1) * Columns(block);
    }
    std::size_t first_row = 0;
    for (std::size_t i = g == 0 ? 0 : group_ends[g - 1]; i < group_ends[g]; ++i) {
      const RowUnit& unit = rows.units[order[i]];
      const auto unit_rows = static_cast<std::size_t>(unit.NumRows());
      for (const RowEntry& entry : EntriesOf(rows, unit)) {
        const auto position = std::lower_bound(blocks.begin(), blocks.end(), entry.block);
        const std::size_t size = Columns(entry.block);
        float* target =
            out.cells_.data() + cell_of_block[static_cast<std::size_t>(position - blocks.begin())];
        std::copy_n(entry.jacobian.begin(), unit_rows * size, target + first_row * size);
        float* noise = target + static_cast<std::size_t>(group.num_rows) * size;
        for (std::size_t c = 0; c < size; ++c) {
          noise[c] += entry.noise[c];
        }
      }
      first_row += unit_rows;
    }
  }

  std::size_t num_cells = 0;
};

ResidualGroups ResidualGroups::Build(const PixelRows& rows, const ParameterSet& set) {
  ResidualGroups groups;
  Builder builder{rows, set, groups, {}, {}};
  builder.SortUnits();
  builder.Partition();
  builder.Fill();
  groups.u.resize(groups.row_sources_.size());
  groups.v.resize(groups.row_sources_.size());
  return groups;
}

void ResidualGroups::FixOffsets() {
  double u2 = 0.0, v2 = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    u2 += u[i] * u[i];
    v2 += v[i] * v[i];
  }
  const double count = static_cast<double>(std::max<std::size_t>(1, u.size()));
  const double per_row = v2 / count + kOffsetFloorShare * u2 / count;
  for (ResidualGroup& group : groups_) {
    double group_v2 = 0.0;
    for (std::int32_t row = 0; row < group.num_rows; ++row) {
      const double value = v[group.first_row + static_cast<std::size_t>(row)];
      group_v2 += value * value;
    }
    group.offset_squared = kOffsetFactor * (group_v2 + group.num_rows * per_row) + 1e-12;
  }
}

}  // namespace pathfit::optim
