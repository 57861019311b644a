#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pathfit::renderer {

/// Discrete distribution over indices with given non-negative weights.
class Distribution1D {
 public:
  Distribution1D() = default;
  /// A total weight of zero leaves the distribution empty.
  explicit Distribution1D(const std::vector<double>& weights);

  [[nodiscard]] bool Empty() const { return total_ <= 0.0; }
  [[nodiscard]] double Total() const { return total_; }
  /// Index of the cell holding u in [0,1); `remainder` is u rescaled to [0,1) inside that cell.
  [[nodiscard]] int Sample(double u, double& remainder) const;
  /// Bring what Sample(u) will read nearer, the second what the first must have brought before.
  void PrefetchBucket(double u) const {
    __builtin_prefetch(&first_of_bucket_[BucketOf(u * cumulative_.back())]);
  }
  void PrefetchSums(double u) const {
    __builtin_prefetch(
        &cumulative_[static_cast<std::size_t>(first_of_bucket_[BucketOf(u * cumulative_.back())])]);
  }
  /// The same among the indices in [first, end), which have some weight.
  [[nodiscard]] int SampleWithin(int first, int end, double u, double& remainder) const {
    const double begin = cumulative_[static_cast<std::size_t>(first)];
    const double target = begin + u * (cumulative_[static_cast<std::size_t>(end)] - begin);
    // Among few, comparing with all needs no branch that is guessed wrong.
    const std::size_t index =
        end - first <= kFew ? CountUpTo(target, first, end) : Search(target, first, end);
    const double width = cumulative_[index + 1] - cumulative_[index];
    remainder =
        width > 0.0 ? std::clamp((target - cumulative_[index]) / width, 0.0, 1.0 - 1e-16) : 0.5;
    return static_cast<int>(index);
  }
  [[nodiscard]] double Probability(int index) const;

 private:
  /// Which of the equal parts of the total, as many as there are weights and one for the total
  /// itself, holds a sum: never a later one for a smaller sum.
  [[nodiscard]] std::size_t BucketOf(double cumulative) const {
    return std::min(static_cast<std::size_t>(cumulative * scale_), probability_.size());
  }
  /// The last index of [first, end) whose sum is not above the target; at least `first`.
  [[nodiscard]] std::size_t Search(double target, int first, int end) const;
  [[nodiscard]] std::size_t CountUpTo(double target, int first, int end) const {
    auto index = static_cast<std::size_t>(first);
    for (auto i = index + 1; i < static_cast<std::size_t>(end); ++i) {
      index += cumulative_[i] <= target ? 1 : 0;
    }
    return index;
  }

  static constexpr int kFew = 8;

  std::vector<double> cumulative_;  // cumulative_[i] = sum of weights before i
  std::vector<double> probability_;
  double total_ = 0.0;
  double scale_ = 0.0;                         // buckets per weight; 0: all are in the first
  std::vector<std::int32_t> first_of_bucket_;  // index into cumulative_, by bucket; and the end
};

}  // namespace pathfit::renderer
