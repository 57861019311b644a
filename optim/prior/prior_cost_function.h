#pragma once

#include <memory>

#include "optim/parameter/parameter_set.h"
#include "optim/prior/prior_terms.h"

namespace ceres {
class CostFunction;
}

namespace pathfit::optim {

/// Residual of a term and, where `jacobians` and its entries are not null, d r / d theta of each
/// block (rows x components, row-major). `theta_blocks[k]` points to the unknowns of
/// term.blocks[k].
void EvalPrior(const PriorTerm& term,
               const ParameterSet& set,
               double const* const* theta_blocks,
               double* residual,
               double** jacobians);

/// EvalPrior for the solver. `term` and `set` must outlive it.
std::unique_ptr<ceres::CostFunction> MakePriorCostFunction(const PriorTerm& term,
                                                           const ParameterSet& set);

}  // namespace pathfit::optim
