#pragma once

#include "optim/problem/loss_spec.h"
#include "optim/problem/problem_size.h"

namespace pathfit::optim {

/// Linear solver of a round whose Jacobian is stored (the dense normal equations are chosen before,
/// by the number of unknowns: ImageProblem::kMaxGramScalars). Cholesky for small problems and for
/// surfaces whose pixels depend on nearby vertices only; conjugate gradients where far couplings
/// (bounces, many texels) would fill the factor. Throws MemoryError if not even conjugate
/// gradients, or the solver asked for, fits.
LinearSolverKind ChooseLinearSolver(LinearSolverChoice choice,
                                    const ProblemSize& size,
                                    double max_bytes);

}  // namespace pathfit::optim
