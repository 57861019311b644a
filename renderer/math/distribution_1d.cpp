#include "renderer/math/distribution_1d.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

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
  const double scale = static_cast<double>(weights.size()) / total_;
  scale_ = std::isfinite(scale) ? scale : 0.0;
  first_of_bucket_.resize(weights.size() + 2);
  for (const double c : cumulative_) ++first_of_bucket_[BucketOf(c) + 1];
  std::partial_sum(first_of_bucket_.begin(), first_of_bucket_.end(), first_of_bucket_.begin());
}

int Distribution1D::Sample(double u, double& remainder) const {
  return SampleWithin(0, static_cast<int>(probability_.size()), u, remainder);
}

std::size_t Distribution1D::Search(double target, int first, int end) const {
  const std::int32_t* const bucket = &first_of_bucket_[BucketOf(target)];
  const auto above = std::upper_bound(cumulative_.begin() + std::clamp(bucket[0], first, end),
                                      cumulative_.begin() + std::clamp(bucket[1], first, end),
                                      target);
  return static_cast<std::size_t>(
      std::max<std::ptrdiff_t>(std::distance(cumulative_.begin(), above) - 1, first));
}

double Distribution1D::Probability(int index) const {
  return probability_[static_cast<std::size_t>(index)];
}

}  // namespace pathfit::renderer
