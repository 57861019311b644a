#include "optim/problem/sample_split.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pathfit::optim {
namespace {

using renderer::SampleBudget;

// Of a boundary term; the interior is the unit.
constexpr double SampleBudget::*BudgetOf(std::size_t term) {
  return renderer::kBoundaryBudgets[term - 1];
}
// Cost of a term over that of the interior: enough to be seen when it matters.
constexpr double kLeastCost = 0.05;
// Of all boundary terms together.
constexpr double kMostCost = 3.0;

/// use(scalar, entry, spread, c, stride) for all rows' components; a row's value is at
/// row * stride + c.
template <class Use>
void ForEachComponent(const PixelRows& rows, const ParameterSet& set, Use use) {
  for (const RowUnit& unit : rows.units) {
    for (std::int32_t e = 0; e < unit.num_entries; ++e) {
      const std::size_t at = unit.first_entry + static_cast<std::size_t>(e);
      const RowEntry& entry = rows.entries[at];
      const auto size = static_cast<std::size_t>(set.BlockSize(entry.block));
      for (std::size_t c = 0; c < size; ++c) {
        use(set.BlockOffset(entry.block) + c, unit, entry, rows.spreads[at], c, size);
      }
    }
  }
}

/// What the noise of J, with the mean residuals, adds to the gradient.
double NoiseByJacobian(const RowUnit& unit,
                       const EntrySpread& spread,
                       std::size_t c,
                       std::size_t size) {
  double sum = 0.0;
  for (std::size_t row = 0; row < static_cast<std::size_t>(unit.NumRows()); ++row) {
    sum += static_cast<double>(spread.jacobian[row * size + c]) * unit.residual[row];
  }
  return sum;
}

}  // namespace

SplitMeter::SplitMeter(const ParameterSet& set)
    : set_(&set),
      image_variance_(set.NumScalars()),
      square_(set.NumScalars()),
      difference_square_(set.NumScalars()) {
  for (Term& term : terms_) {
    term.variance.assign(set.NumScalars(), 0.0);
  }
}

void SplitMeter::AddTerms(const View& view) {
  PixelRows rows;
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const auto& a = view.terms_a.parts()[t];
    const auto& b = view.terms_b.parts()[t];
    if (!a || !b) {
      continue;
    }
    Term& term = terms_[t];
    term.num_samples += static_cast<double>(a->num_samples + b->num_samples);
    HalvesMerger merger({view.film_a, view.film_b, a->sink, b->sink},
                        view.level,
                        view.scales,
                        *set_,
                        view.values,
                        view.name);
    while (merger.HasNext()) {
      merger.Next(rows);
      ForEachComponent(rows,
                       *set_,
                       [&](std::size_t scalar,
                           const RowUnit& unit,
                           const auto&,
                           const auto& spread,
                           auto... at) {
                         const double noise = NoiseByJacobian(unit, spread, at...);
                         term.variance[scalar] += noise * noise;
                       });
    }
  }
}

void SplitMeter::AddRows(const PixelRows& rows) {
  ForEachComponent(
      rows,
      *set_,
      [&](std::size_t scalar,
          const RowUnit& unit,
          const RowEntry& entry,
          const EntrySpread& spread,
          std::size_t c,
          std::size_t size) {
        const double by_images =
            static_cast<double>(spread.gradient[c]) - NoiseByJacobian(unit, spread, c, size);
        image_variance_[scalar] += by_images * by_images;
        for (std::size_t row = 0; row < static_cast<std::size_t>(unit.NumRows()); ++row) {
          const auto mean = static_cast<double>(entry.jacobian[row * size + c]);
          const auto difference = static_cast<double>(spread.jacobian[row * size + c]);
          square_[scalar] += mean * mean;
          difference_square_[scalar] += difference * difference;
        }
      });
}

void SplitMeter::Add(const SplitMeter& other) {
  const auto add = [](const std::vector<double>& from, std::vector<double>& to) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += from[i];
  };
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    add(other.terms_[t].variance, terms_[t].variance);
    terms_[t].num_samples += other.terms_[t].num_samples;
  }
  add(other.image_variance_, image_variance_);
  add(other.square_, square_);
  add(other.difference_square_, difference_square_);
}

SampleBudget SplitMeter::Improve(const SampleBudget& used,
                                 const std::optional<SampleBudget>& at_cost_of) const {
  // Best costs of the terms are as the roots of variance times cost, at the numbers in use.
  std::array<double, renderer::kNumDerivativeTerms> cost{};
  std::array<double, renderer::kNumDerivativeTerms> best{};
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    double variance = 0.0;
    for (std::size_t i = 0; i < square_.size(); ++i) {
      const double curvature =
          std::max(square_[i] - difference_square_[i], kLeastTrueShare * square_[i]);
      if (curvature > 0.0) {
        variance += (terms_[t].variance[i] + (t == 0 ? image_variance_[i] : 0.0)) / curvature;
      }
    }
    cost[t] = renderer::kPathsPerSample[t] * terms_[t].num_samples;
    best[t] = std::sqrt(variance * cost[t]);
  }
  SampleBudget split = used;
  if (!(best[0] > 0.0)) {
    return split;
  }
  double boundaries = 0.0;
  double wanted = 0.0;
  for (std::size_t t = 1; t < terms_.size(); ++t) {
    best[t] = cost[t] > 0.0 ? std::max(best[t] / best[0], kLeastCost) : 0.0;
    boundaries += best[t];
    if (at_cost_of && cost[t] > 0.0) {
      wanted += cost[t] / cost[0] * (*at_cost_of).*BudgetOf(t) / used.*BudgetOf(t);
    }
  }
  if (!at_cost_of) {
    wanted = std::min(boundaries, kMostCost);
  }
  const double limit = boundaries > 0.0 ? wanted / boundaries : 1.0;
  for (std::size_t t = 1; t < terms_.size(); ++t) {
    if (cost[t] > 0.0) {
      split.*BudgetOf(t) *= std::sqrt(best[t] * limit * cost[0] / cost[t]);
    }
  }
  return split;
}

}  // namespace pathfit::optim
