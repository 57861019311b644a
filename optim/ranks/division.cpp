#include "optim/ranks/division.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace pathfit::optim {
namespace {

// Share of a rank's time that it may be behind and still be given what it has the photo of.
constexpr double kPatience = 0.05;

constexpr int kNothing = -1;

}  // namespace

std::vector<int> Deal(const std::vector<ItemCost>& costs,
                      int num_ranks,
                      const std::vector<int>& homes) {
  std::vector<int> best(costs.size());
  if (num_ranks == 1) return best;
  double taking = 0.0;
  double making = 0.0;
  for (const ItemCost& cost : costs) {
    taking += cost.taking;
    making += cost.making;
  }
  const double patience = kPatience * making / num_ranks;
  double least = std::numeric_limits<double>::infinity();
  double own = 0.0;
  for (std::size_t first = 0; first <= costs.size(); ++first) {
    // Each of the others' items goes to the rank that is free first, or about then.
    std::vector<double> busy(static_cast<std::size_t>(num_ranks));
    std::vector<int> dealt(costs.size());
    double last = 0.0;
    for (std::size_t i = first; i < costs.size(); ++i) {
      auto free = std::min_element(busy.begin() + 1, busy.end());
      const auto home = busy.begin() + (homes.empty() ? 0 : homes[i]);
      if (home != busy.begin() && *home <= *free + patience) free = home;
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
  return DealItems(kind, std::vector<int>(count, kNothing));
}

std::vector<int> Division::DealItems(Kind kind, const std::vector<int>& things) {
  const std::size_t count = things.size();
  if (IsAlone()) return std::vector<int>(count);
  std::vector<int> rank_of;
  if (IsFirst()) {
    std::vector<ItemCost> costs = costs_[kind];
    if (costs.size() != count) costs.assign(count, {1.0, 0.0});
    std::vector<int> homes(count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto home = homes_.find(things[i]);
      homes[i] = home == homes_.end() ? 0 : home->second;
    }
    rank_of = Deal(costs, ranks_->count(), homes);
    for (std::size_t i = 0; i < count; ++i) {
      if (rank_of[i] > 0 && things[i] != kNothing) homes_[things[i]] = rank_of[i];
    }
  }
  return Share(std::move(rank_of));
}

}  // namespace pathfit::optim
