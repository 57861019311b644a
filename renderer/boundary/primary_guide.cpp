#include "renderer/boundary/primary_guide.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/check.h"

namespace pathfit::renderer {

PrimaryGuide PrimaryGuide::Build(GuideKind kind,
                                 int dimensions,
                                 std::int64_t num_pilots,
                                 const Pilot& pilot) {
  PATHFIT_CHECK(dimensions >= 1 && dimensions <= 3);
  if (kind == GuideKind::kNone || num_pilots <= 0) {
    return {};
  }
  return PrimaryGuide(kind == GuideKind::kGrid ? GridCells(dimensions, num_pilots, pilot)
                                               : AdaptiveCells(dimensions, num_pilots, pilot),
                      num_pilots);
}

PrimaryGuide::PrimaryGuide(std::span<const GuideCell> cells, std::int64_t num_pilots)
    : num_pilots_(num_pilots) {
  double total = 0.0;
  for (const GuideCell& cell : cells) {
    total += cell.Volume() * std::sqrt(cell.mean_square);
    mass_ += cell.Volume() * cell.mean;
  }
  if (!(total > 0.0) || !std::isfinite(total)) {
    return;
  }
  double sum = 0.0;
  for (const GuideCell& cell : cells) {
    const double pdf = kUniformShare + (1.0 - kUniformShare) * std::sqrt(cell.mean_square) / total;
    cells_.push_back({cell.low, cell.size, pdf});
    cumulative_.push_back(sum);
    sum += pdf * cell.Volume();
  }
  for (std::size_t i = 0; i < cells_.size(); ++i) {  // what rounding left of 1
    cells_[i].pdf /= sum;
    cumulative_[i] /= sum;
  }
}

PrimaryGuide::Draw PrimaryGuide::Sample(double u0, double u1, double u2) const {
  Draw draw{{u0, u1, u2}, 1.0};
  if (cells_.empty()) {
    return draw;
  }
  const auto above = std::upper_bound(cumulative_.begin() + 1, cumulative_.end(), u0);
  const auto index = static_cast<std::size_t>(above - cumulative_.begin()) - 1;
  const Cell& cell = cells_[index];
  const double end = index + 1 < cells_.size() ? cumulative_[index + 1] : 1.0;
  draw.u[0] = (u0 - cumulative_[index]) / (end - cumulative_[index]);
  for (std::size_t i = 0; i < 3; ++i) {
    draw.u[i] = std::clamp(cell.low[i] + cell.size[i] * draw.u[i], 0.0, 1.0 - 0x1.0p-53);
  }
  draw.pdf = cell.pdf;
  return draw;
}

}  // namespace pathfit::renderer
