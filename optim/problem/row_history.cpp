#include "optim/problem/row_history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/pixel_rows.h"
#include "renderer/core/parallel.h"

namespace pathfit::optim {
namespace {

std::int32_t KeyOf(const RowUnit& unit) { return 2 * unit.pixel + (unit.is_coverage ? 1 : 0); }
std::size_t NumRows(std::int32_t key) { return key % 2 == 0 ? 3 : 1; }

/// Room for the units of both, with what is summed so far.
SummedRows Union(const SummedRows& sums, const PixelRows& rows, std::size_t num_scalars) {
  SummedRows both;
  std::size_t next = 0, row = 0;
  const auto take = [&](std::int32_t key, bool is_summed) {
    both.units.push_back(key);
    const std::size_t count = 2 * NumRows(key);
    const std::size_t end = both.residuals.size();
    both.residuals.resize(end + count);
    both.jacobians.resize((end + count) * num_scalars);
    if (is_summed) {
      std::copy_n(sums.residuals.data() + row, count, both.residuals.data() + end);
      std::copy_n(sums.jacobians.data() + row * num_scalars,
                  count * num_scalars,
                  both.jacobians.data() + end * num_scalars);
      row += count;
      ++next;
    }
  };
  for (const RowUnit& unit : rows.units) {
    const std::int32_t key = KeyOf(unit);
    while (next < sums.units.size() && sums.units[next] < key) {
      take(sums.units[next], true);
    }
    take(key, next < sums.units.size() && sums.units[next] == key);
  }
  while (next < sums.units.size()) {
    take(sums.units[next], true);
  }
  return both;
}

void AddWeighted(const PixelRows& rows,
                 const RowUnit& unit,
                 double weight,
                 const ParameterSet& set,
                 double* residuals,
                 float* jacobians) {
  const std::size_t n = set.NumScalars();
  const auto num_rows = static_cast<std::size_t>(unit.NumRows());
  for (std::size_t row = 0; row < num_rows; ++row) {
    residuals[2 * row] += weight * (unit.residual[row] + unit.difference[row]);
    residuals[2 * row + 1] += weight * (unit.residual[row] - unit.difference[row]);
  }
  for (std::size_t e = 0; e < static_cast<std::size_t>(unit.num_entries); ++e) {
    const RowEntry& entry = rows.entries[unit.first_entry + e];
    const EntrySpread& spread = rows.spreads[unit.first_entry + e];
    const auto size = static_cast<std::size_t>(set.BlockSize(entry.block));
    for (std::size_t row = 0; row < num_rows; ++row) {
      float* half_a = jacobians + 2 * row * n + set.BlockOffset(entry.block);
      float* half_b = half_a + n;
      for (std::size_t c = 0; c < size; ++c) {
        const auto mean = static_cast<double>(entry.jacobian[row * size + c]);
        const auto difference = static_cast<double>(spread.jacobian[row * size + c]);
        half_a[c] += static_cast<float>(weight * (mean + difference));
        half_b[c] += static_cast<float>(weight * (mean - difference));
      }
    }
  }
}

}  // namespace

RowHistory::RowHistory(std::size_t num_views, std::size_t num_scalars)
    : theta(num_scalars), views(num_views) {}

double RowHistory::Bytes(double num_pixels, std::size_t num_scalars, bool with_coverage) {
  const double rows = num_pixels * (with_coverage ? 4.0 : 3.0);
  return 2.0 * rows * (sizeof(float) * static_cast<double>(num_scalars) + sizeof(double));
}

bool RowHistory::IsValid() const {
  const auto is_finite = [](auto x) { return std::isfinite(x); };
  return weight >= 0.0 && std::isfinite(weight) && std::ranges::all_of(theta, is_finite) &&
         std::ranges::all_of(views, [&](const SummedRows& view) {
           std::size_t count = 0;
           std::int32_t last = -1;
           for (const std::int32_t key : view.units) {
             if (key <= last) return false;
             last = key;
             count += 2 * NumRows(key);
           }
           return view.residuals.size() == count && view.jacobians.size() == count * theta.size() &&
                  std::ranges::all_of(view.residuals, is_finite) &&
                  std::ranges::all_of(view.jacobians, is_finite);
         });
}

void RowHistory::Fade(double kept) {
  if (kept == 1.0) {
    return;
  }
  for (SummedRows& view : views) {
    for (double& x : view.residuals) x *= kept;
    for (float& x : view.jacobians) x *= static_cast<float>(kept);
  }
  weight *= kept;
}

void RowHistory::Add(const std::vector<PixelRows>& round,
                     const std::vector<double>& at,
                     double round_weight,
                     const ParameterSet& set) {
  const std::size_t n = theta.size();
  std::vector<double> step(n);
  for (std::size_t i = 0; i < n; ++i) {
    step[i] = at[i] - theta[i];
  }
  renderer::ParallelFor(static_cast<std::int64_t>(views.size()), [&](std::int64_t index) {
    SummedRows& sums = views[static_cast<std::size_t>(index)];
    const PixelRows& rows = round[static_cast<std::size_t>(index)];
    for (std::size_t k = 0; k < sums.residuals.size(); ++k) {
      for (std::size_t i = 0; i < n; ++i) {
        sums.residuals[k] += static_cast<double>(sums.jacobians[k * n + i]) * step[i];
      }
    }
    sums = Union(sums, rows, n);
    std::size_t unit = 0, row = 0;
    for (const std::int32_t key : sums.units) {
      if (unit < rows.units.size() && KeyOf(rows.units[unit]) == key) {
        AddWeighted(rows,
                    rows.units[unit],
                    round_weight,
                    set,
                    sums.residuals.data() + row,
                    sums.jacobians.data() + row * n);
        ++unit;
      }
      row += 2 * NumRows(key);
    }
  });
  theta = at;
  weight += round_weight;
}

PixelRows RowHistory::Means(std::size_t view, const ParameterSet& set) const {
  const std::size_t n = theta.size();
  const SummedRows& sums = views[view];
  const double scale = 1.0 / weight;
  PixelRows rows;
  const double* residuals = sums.residuals.data();
  const float* jacobians = sums.jacobians.data();
  for (const std::int32_t key : sums.units) {
    RowUnit unit;
    unit.pixel = key / 2;
    unit.is_coverage = key % 2 != 0;
    unit.first_entry = rows.entries.size();
    const std::size_t num_rows = NumRows(key);
    std::array<double, 3> a{}, b{};
    for (std::size_t row = 0; row < num_rows; ++row) {
      a[row] = scale * residuals[2 * row];
      b[row] = scale * residuals[2 * row + 1];
    }
    unit.SetResiduals(a, b);
    for (std::int32_t block = 0; block < static_cast<std::int32_t>(set.NumBlocks()); ++block) {
      HalvesEntry halves{block, {}, {}};
      const auto size = static_cast<std::size_t>(set.BlockSize(block));
      for (std::size_t row = 0; row < num_rows; ++row) {
        const float* half_a = jacobians + 2 * row * n + set.BlockOffset(block);
        for (std::size_t c = 0; c < size; ++c) {
          halves.a[row * size + c] = scale * static_cast<double>(half_a[c]);
          halves.b[row * size + c] = scale * static_cast<double>(half_a[n + c]);
        }
      }
      rows.AddEntry(unit, halves, static_cast<int>(size));
    }
    unit.num_entries = static_cast<std::int32_t>(rows.entries.size() - unit.first_entry);
    if (unit.num_entries > 0) {
      rows.units.push_back(unit);
    }
    residuals += 2 * num_rows;
    jacobians += 2 * num_rows * n;
  }
  return rows;
}

}  // namespace pathfit::optim
