#pragma once

#include <cstddef>
#include <memory>

#include "optim/problem/image_problem.h"

namespace ceres {
class CostFunction;
}

namespace pathfit::optim {

/// What the cost functions should answer at the point the solver evaluates; set by the evaluation
/// callback.
struct EvaluationState {
  bool at_start = true;  ///< the linearisation point; later points have primal renderings only
  bool zero_jacobians = false;  ///< after acceptance: the round ends, nobody uses these
  bool refused = false;         ///< the trial point is not admissible: no residuals
};

/// The cost functions copy from `problem` and `state`, which must outlive them.
/// Of one panel of the roots, by its support's blocks from the panel's first on. At trial points
/// all residuals are zero, and the rest is the whole cost.
std::unique_ptr<ceres::CostFunction> MakePanelCostFunction(const ImageProblem& problem,
                                                           const EvaluationState& state,
                                                           std::size_t panel);
/// One cost function of all blocks, in the layout's order.
std::unique_ptr<ceres::CostFunction> MakeGramCostFunction(const ImageProblem& problem,
                                                          const EvaluationState& state);
/// One residual for what the roots do not hold: at the start, the part of the cost that no
/// parameter explains. Depends formally on block `block`.
std::unique_ptr<ceres::CostFunction> MakeRestCostFunction(const ImageProblem& problem,
                                                          const EvaluationState& state,
                                                          std::int32_t block);

}  // namespace pathfit::optim
