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
std::unique_ptr<ceres::CostFunction> MakeGroupCostFunction(const ImageProblem& problem,
                                                           const EvaluationState& state,
                                                           std::size_t view,
                                                           std::size_t group);
/// One cost function of all blocks, in the layout's order.
std::unique_ptr<ceres::CostFunction> MakeGramCostFunction(const ImageProblem& problem,
                                                          const EvaluationState& state);
/// Cost of the pixels without derivatives: it has none either, but a trial that uncovers them must
/// pay. Depends formally on block `block`.
std::unique_ptr<ceres::CostFunction> MakeRestCostFunction(const ImageProblem& problem,
                                                          const EvaluationState& state,
                                                          std::int32_t block);

}  // namespace pathfit::optim
