#pragma once

#include <vector>

#include "optim/problem/quadratic_model.h"
#include "optim/problem/row_history.h"

namespace pathfit::optim {

struct FitViews;

/// What rounds of few unknowns have told together.
struct RoundSums {
  QuadraticModel model;  ///< of all rounds
  QuadraticModel apart;  ///< of those that are not in `rows`
  RowHistory rows;

  /// All of a model in which they are apart.
  static RoundSums Of(QuadraticModel model);

  /// Memory of the rows of all fitted views, of that share of their pixels; 0 if they are too many
  /// to be kept. `max_memory_bytes`: of everything, 0 = no limit.
  static double BytesOfRows(const FitViews& views,
                            double share_of_pixels,
                            std::size_t num_scalars,
                            double max_memory_bytes);

  /// Adds a round, finished at `theta`, by its rows (by fitted view), or by its model where there
  /// are none; earlier ones fade as far as it contradicts them. `weight`: proportional to its
  /// samples.
  void Add(const QuadraticModel& round,
           const std::vector<PixelRows>& rows_of_round,
           const std::vector<double>& theta,
           double weight,
           const ParameterSet& set);
  /// After a step: rounds fade as far as it leads away from them.
  void Forget(const std::vector<double>& step);
};

}  // namespace pathfit::optim
