#include "optim/ranks/division.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace pathfit::optim {
namespace {

// Share of a rank's time by which one may have more to do than another before items move.
constexpr double kPatience = 0.05;

constexpr int kNothing = -1;

/// The items from `first` on, among the ranks beside the first: each to its home or, without one,
/// to the rank that has least to do; then items move as long as that makes them more even.
std::vector<int> DealToOthers(const std::vector<ItemCost>& costs,
                              std::size_t first,
                              int num_ranks,
                              const std::vector<int>& homes) {
  std::vector<int> dealt(costs.size());
  std::vector<double> busy(static_cast<std::size_t>(num_ranks));
  double making = 0.0;
  const auto give = [&](std::size_t item, int rank) {
    dealt[item] = rank;
    busy[static_cast<std::size_t>(rank)] += costs[item].making;
  };
  for (std::size_t i = first; i < costs.size(); ++i) {
    making += costs[i].making;
    if (!homes.empty() && homes[i] > 0) give(i, homes[i]);
  }
  for (std::size_t i = first; i < costs.size(); ++i) {
    if (dealt[i] > 0) continue;
    give(i, static_cast<int>(std::min_element(busy.begin() + 1, busy.end()) - busy.begin()));
  }
  for (std::size_t moves = 0; moves < costs.size(); ++moves) {
    const auto [low, high] = std::minmax_element(busy.begin() + 1, busy.end());
    const double excess = *high - *low;
    if (excess <= kPatience * making / num_ranks) break;
    const int from = static_cast<int>(high - busy.begin());
    // The one that evens out best: any that costs less than the excess does.
    std::size_t best = costs.size();
    double best_rest = excess;
    for (std::size_t i = first; i < costs.size(); ++i) {
      const double rest = std::abs(excess - 2.0 * costs[i].making);
      if (dealt[i] != from || rest >= best_rest) continue;
      best = i;
      best_rest = rest;
    }
    if (best == costs.size()) break;
    *high -= costs[best].making;
    give(best, static_cast<int>(low - busy.begin()));
  }
  return dealt;
}

}  // namespace

std::vector<int> Deal(const std::vector<ItemCost>& costs,
                      int num_ranks,
                      const std::vector<int>& homes) {
  std::vector<int> best(costs.size());
  if (num_ranks == 1) return best;
  double taking = 0.0;
  for (const ItemCost& cost : costs) taking += cost.taking;
  double least = std::numeric_limits<double>::infinity();
  double own = 0.0;
  for (std::size_t first = 0; first <= costs.size(); ++first) {
    std::vector<int> dealt = DealToOthers(costs, first, num_ranks, homes);
    std::vector<double> busy(static_cast<std::size_t>(num_ranks));
    double last = 0.0;
    for (std::size_t i = first; i < costs.size(); ++i) {
      double& end = busy[static_cast<std::size_t>(dealt[i])];
      end += costs[i].making;
      last = std::max(last, end + costs[i].taking);
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
