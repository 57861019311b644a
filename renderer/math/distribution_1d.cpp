#include "renderer/math/distribution_1d.h"

#include <algorithm>

namespace pathfit::renderer {

Distribution1D::Distribution1D(const std::vector<double>& weights) : cumulative_{0.0} {
  cumulative_.reserve(weights.size() + 1);
  for (const double w : weights) {
    total_ += w;
    cumulative_.push_back(total_);
  }
  if (total_ <= 0.0) return;
  probability_.reserve(weights.size());
  for (const double w : weights) probability_.push_back(w / total_);
}

int Distribution1D::Sample(double u, double& remainder) const {
  const double target = u * total_;
  const auto above = std::ranges::upper_bound(cumulative_, target);
  auto index = static_cast<std::size_t>(std::distance(cumulative_.begin(), above)) - 1;
  index = std::min(index, probability_.size() - 1);
  const double width = cumulative_[index + 1] - cumulative_[index];
  remainder =
      width > 0.0 ? std::clamp((target - cumulative_[index]) / width, 0.0, 1.0 - 1e-16) : 0.5;
  return static_cast<int>(index);
}

double Distribution1D::Probability(int index) const {
  return probability_[static_cast<std::size_t>(index)];
}

}  // namespace pathfit::renderer
