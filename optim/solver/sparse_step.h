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

/// Standard errors of many unknowns by theta (of_photos, of_ranges) at the point where `problem` is
/// linearised with draws of its gradient, which it uses up; no block is spread (PairedBlocks): root
/// mean squares of A^-1 g over draws g of the photos' gradient and of the priors'
/// (DrawPriorGradients), A the matrix of both, and how far beyond chance the point is from the
/// minimum that A and the gradient tell, since fits of many unknowns end before they are there. So
/// what photos hardly tell is as uncertain as its
/// neighbours and `residual`, the size of a residual that nothing explains, leave it. With
/// GradientDraws::kCount draws they are known to a quarter of themselves; what twenty conjugate
/// gradients do not reach, changes of a whole surface that photos hardly tell, counts too little.
/// Infinite (of_ranges) for scalars that no pixel depends on.
StandardErrors EstimateErrorsOfMany(ImageProblem& problem,
                                    const std::vector<PriorTerm>& priors,
                                    const std::vector<double>& theta,
                                    double residual);

}  // namespace pathfit::optim
