#pragma once

#include <functional>
#include <string>
#include <vector>

#include "optim/prior/prior_terms.h"
#include "optim/problem/image_problem.h"
#include "optim/problem/loss_spec.h"
#include "optim/problem/problem_size.h"

namespace pathfit::optim {

/// Version of the Ceres headers.
std::string CeresVersion();

/// Linear solver of a round that keeps rows: the one asked for. Throws MemoryError if it does not
/// fit.
LinearSolverKind SolverOfRows(LinearSolverChoice choice, const ProblemSize& size, double max_bytes);

/// Trials after the first before a round gives up.
inline constexpr int kMaxRejections = 8;
/// Of an iterative linear solver, for one trial.
inline constexpr int kMaxConjugateSteps = 200;

struct SolveOptions {
  LinearSolverKind linear_solver = LinearSolverKind::kGram;
  double radius = 1.0;  ///< trust region, first and largest
  /// Of the radius, for the blocks of small groups (a camera, a light, a material) beside many
  /// others: most pixels tell them, so that their part of a step has little noise. Sparse normal
  /// equations only.
  double shared_radius_factor = 1.0;
  /// Of a step by the model, what is tried first. Sparse normal equations only.
  double step_share = 1.0;
  double eta = 0.01;  ///< relative accuracy of conjugate gradients
  /// Whether a trial (values in units of the scene) may be rendered at all, where it may change it
  /// first: what is rendered and accepted is the changed one. Empty = always.
  std::function<bool(std::vector<double>&)> restrain;
};

struct SolveOutcome {
  bool accepted = false;
  std::vector<double> theta;       ///< the accepted point, or the start
  int trials = 0;                  ///< radii that were tried
  int refused = 0;                 ///< of them, that could not be rendered
  double relative_decrease = 0.0;  ///< actual over predicted, of the accepted step
  double radius = 0.0;             ///< of the last trial
  double step_share = 1.0;         ///< for the next round, by what the trials cost
  double linear_s = 0.0;           ///< wall time outside of rendering
  double render_s = 0.0;           ///< wall time of the trials' renderings
  std::string failure;             ///< the solver's own words if it gave up; empty = it did not
};

/// One Levenberg-Marquardt step from `theta`, where `problem` has been linearised: trials shrink
/// the radius until one is accepted; of sparse normal equations each may be tried again with less
/// of the step. Deterministic: one thread, samples fixed. On return
/// problem.costs() are those of the last trial, which is the accepted one if any. Throws what
/// rendering throws (a SceneError only refuses the trial) and NumericalError if the start cannot be
/// evaluated.
SolveOutcome SolveRound(ImageProblem& problem,
                        const std::vector<PriorTerm>& priors,
                        const std::vector<PriorTerm>& proximal,
                        const std::vector<double>& theta,
                        const SolveOptions& options);

}  // namespace pathfit::optim
