#pragma once

#include <vector>

#include "optim/solver/trust_region_solver.h"

namespace pathfit::optim {

/// SolveRound on the sparse normal equations of `problem`, which it uses up: the priors' are added
/// in place. Where derivatives have no noise, steps are those of conjugate gradients on the rows:
/// the same damping, preconditioner, ends of iterations and acceptance.
SolveOutcome SolveSparseRound(ImageProblem& problem,
                              const std::vector<PriorTerm>& priors,
                              const std::vector<PriorTerm>& proximal,
                              const std::vector<double>& theta,
                              const SolveOptions& options);

}  // namespace pathfit::optim
