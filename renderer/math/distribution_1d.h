#pragma once

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
  /// The same among the indices in [first, end), which have some weight.
  [[nodiscard]] int SampleWithin(int first, int end, double u, double& remainder) const;
  [[nodiscard]] double Probability(int index) const;

 private:
  /// Which of the equal parts of the total, as many as there are weights and one for the total
  /// itself, holds a sum: never a later one for a smaller sum.
  [[nodiscard]] std::size_t BucketOf(double cumulative) const;

  std::vector<double> cumulative_;  // cumulative_[i] = sum of weights before i
  std::vector<double> probability_;
  double total_ = 0.0;
  double scale_ = 0.0;                         // buckets per weight; 0: all are in the first
  std::vector<std::int32_t> first_of_bucket_;  // index into cumulative_, by bucket; and the end
};

}  // namespace pathfit::renderer
