#include "optim/problem/gradient_draws.h"

#include "renderer/core/parallel.h"
#include "renderer/sampler/counter_rng.h"

namespace pathfit::optim {

GradientDraws::GradientDraws(std::size_t num_scalars, std::uint64_t seed)
    : seed_(seed), draws_(kCount, std::vector<double>(num_scalars)) {}

void GradientDraws::Add(const PixelRows& rows, const ParameterSet& set, std::size_t view) {
  std::vector<std::uint64_t> signs;  // by unit, a bit for each draw
  signs.reserve(rows.units.size());
  for (const RowUnit& unit : rows.units) {
    const auto element = 2 * static_cast<std::uint64_t>(unit.pixel) + (unit.is_coverage ? 1 : 0);
    signs.push_back(
        renderer::CounterRng(seed_, renderer::RandomDomain::kGradientSign, view, element)
            .NextInteger());
  }
  renderer::ParallelFor(kCount, [&](std::int64_t k) {
    std::vector<double>& draw = draws_[static_cast<std::size_t>(k)];
    for (std::size_t u = 0; u < rows.units.size(); ++u) {
      const RowUnit& unit = rows.units[u];
      const double sign = (signs[u] >> k & 1) != 0 ? 1.0 : -1.0;
      const std::size_t end = unit.first_entry + static_cast<std::size_t>(unit.num_entries);
      for (std::size_t e = unit.first_entry; e < end; ++e) {
        const std::size_t offset = set.BlockOffset(rows.entries[e].block);
        const auto size = static_cast<std::size_t>(set.BlockSize(rows.entries[e].block));
        for (std::size_t c = 0; c < size; ++c) {
          draw[offset + c] += sign * static_cast<double>(rows.spreads[e].mean_gradient[c]);
        }
      }
    }
  });
}

}  // namespace pathfit::optim
