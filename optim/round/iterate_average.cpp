#include "optim/round/iterate_average.h"

#include <cstddef>

namespace pathfit::optim {

void AddIterate(AverageState& average, int round, double weight, const std::vector<double>& theta) {
  if (round >= 2 * average.newer_start) {
    average.older_sum = std::move(average.newer_sum);
    average.older_weight = average.newer_weight;
    average.newer_sum.clear();
    average.newer_weight = 0.0;
    average.newer_start = round;
  }
  average.newer_sum.resize(theta.size(), 0.0);
  for (std::size_t i = 0; i < theta.size(); ++i) {
    average.newer_sum[i] += weight * theta[i];
  }
  average.newer_weight += weight;
}

std::vector<double> AverageIterate(const AverageState& average) {
  std::vector<double> mean = average.newer_sum;
  const double weight = average.older_weight + average.newer_weight;
  for (std::size_t i = 0; i < mean.size(); ++i) {
    mean[i] = (mean[i] + (average.older_sum.empty() ? 0.0 : average.older_sum[i])) / weight;
  }
  return mean;
}

}  // namespace pathfit::optim
