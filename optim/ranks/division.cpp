#include "optim/ranks/division.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace pathfit::optim {

std::vector<int> Deal(const std::vector<ItemCost>& costs, int num_ranks) {
  std::vector<int> best(costs.size());
  if (num_ranks == 1) return best;
  double taking = 0.0;
  for (const ItemCost& cost : costs) taking += cost.taking;
  double least = std::numeric_limits<double>::infinity();
  double own = 0.0;
  for (std::size_t first = 0; first <= costs.size(); ++first) {
    // Each of the others' items goes to the rank that is free first.
    std::vector<double> busy(static_cast<std::size_t>(num_ranks));
    std::vector<int> dealt(costs.size());
    double last = 0.0;
    for (std::size_t i = first; i < costs.size(); ++i) {
      const auto free = std::min_element(busy.begin() + 1, busy.end());
      *free += costs[i].making;
      dealt[i] = static_cast<int>(free - busy.begin());
      last = std::max(last, *free + costs[i].taking);
    }
    const double end = std::max(own + taking, last);
    if (end < least) {
      least = end;
      best = std::move(dealt);
    }
    if (first < costs.size()) own += costs[first].making;
  }
  return best;
}

std::vector<int> Division::DealItems(Kind kind, std::size_t count) {
  if (IsAlone()) return std::vector<int>(count);
  std::vector<int> rank_of;
  if (IsFirst()) {
    std::vector<ItemCost> costs = costs_[kind];
    if (costs.size() != count) costs.assign(count, {1.0, 0.0});
    rank_of = Deal(costs, ranks_->count());
  }
  return Share(std::move(rank_of));
}

}  // namespace pathfit::optim
