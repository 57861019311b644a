#include "optim/solver/trust_region_solver.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <exception>

#include <ceres/ceres.h>
#include <glog/logging.h>

#include "optim/prior/prior_terms.h"
#include "optim/problem/image_cost_functions.h"
#include "optim/solver/sparse_step.h"
#include "optim/solver/step_bounds.h"
#include "renderer/core/clock.h"
#include "renderer/core/error.h"

// OpenBLAS's own header is not installed with every package that provides the library.
// NOLINTNEXTLINE(readability-identifier-naming): the library's name.
extern "C" void openblas_set_num_threads(int num_threads);

namespace pathfit::optim {
namespace {

// Above this, priors beside a dense system are cheaper kept sparse.
constexpr int kMaxDenseRows = 3000;

class SilenceLog {
 public:
  SilenceLog() : before_(FLAGS_minloglevel) { FLAGS_minloglevel = google::GLOG_FATAL; }
  ~SilenceLog() { FLAGS_minloglevel = before_; }
  SilenceLog(const SilenceLog&) = delete;
  SilenceLog& operator=(const SilenceLog&) = delete;

 private:
  int before_;
};

// Renders trial points; the start has been rendered by the linearisation, and nothing uses a
// Jacobian after acceptance. What rendering throws is kept and refuses the trial, so that it need
// not cross Ceres; SolveRound throws it again.
class RenderCallback : public ceres::EvaluationCallback {
 public:
  RenderCallback(ImageProblem& problem,
                 const std::vector<double>& theta,
                 const SolveOptions& options,
                 EvaluationState& state)
      : problem_(problem), theta_(theta), options_(options), state_(state) {}

  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override {
    if (is_first_) {
      is_first_ = false;
      return;
    }
    if (evaluate_jacobians) {
      state_.zero_jacobians = true;
    }
    if (!new_evaluation_point) {
      return;
    }
    ++trials_;
    state_.at_start = false;
    state_.refused = true;
    const auto start = renderer::Clock::now();
    try {
      std::vector<double> values = problem_.set().ValuesFromTheta(theta_);
      const std::vector<double> wanted = values;
      if (!error_ && (!options_.restrain || options_.restrain(values))) {
        problem_.EvalTrial(values);
        state_.refused = false;
        trial_ = values == wanted ? theta_ : problem_.set().ThetaFromValues(values);
      }
    } catch (const renderer::SceneError&) {
      // The step leads out of what can be rendered.
    } catch (...) {
      error_ = std::current_exception();
    }
    refused_ += state_.refused ? 1 : 0;
    seconds_ += renderer::SecondsSince(start);
  }

  [[nodiscard]] const std::exception_ptr& error() const { return error_; }
  [[nodiscard]] double seconds() const { return seconds_; }
  [[nodiscard]] int trials() const { return trials_; }
  [[nodiscard]] int refused() const { return refused_; }
  /// The last point that was rendered.
  [[nodiscard]] const std::vector<double>& trial() const { return trial_; }

 private:
  ImageProblem& problem_;
  const std::vector<double>& theta_;
  const SolveOptions& options_;
  EvaluationState& state_;
  bool is_first_ = true;
  int trials_ = 0;
  int refused_ = 0;
  std::vector<double> trial_;
  double seconds_ = 0.0;
  std::exception_ptr error_;
};

// Ends the solve with the first accepted step, since iterating on would fit the noise of this
// sample set, or with an error.
class StopAfterStep : public ceres::IterationCallback {
 public:
  StopAfterStep(const RenderCallback& render, SolveOutcome& outcome)
      : render_(render), outcome_(outcome) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (render_.error()) {
      return ceres::SOLVER_ABORT;
    }
    if (summary.iteration == 0 || !summary.step_is_successful) {
      return ceres::SOLVER_CONTINUE;
    }
    outcome_.accepted = true;
    outcome_.relative_decrease = summary.relative_decrease;
    return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

 private:
  const RenderCallback& render_;
  SolveOutcome& outcome_;
};

class ProblemBuilder {
 public:
  ProblemBuilder(const ImageProblem& image, std::vector<double>& theta, ceres::Problem& problem)
      : image_(image), theta_(theta), problem_(problem), used_(image.set().NumBlocks()) {}

  void Add(std::unique_ptr<ceres::CostFunction> cost,
           const std::int32_t* blocks,
           std::size_t count,
           std::unique_ptr<ceres::LossFunction> loss = nullptr) {
    pointers_.clear();
    for (std::size_t k = 0; k < count; ++k) {
      pointers_.push_back(theta_.data() + image_.set().BlockOffset(blocks[k]));
      used_[static_cast<std::size_t>(blocks[k])] = 1;
    }
    num_rows_ += cost->num_residuals();
    problem_.AddResidualBlock(cost.release(), loss.release(), pointers_);
  }

  void AddImages(const EvaluationState& state) {
    if (image_.UsesGram()) {
      std::vector<std::int32_t> all;
      for (std::size_t b = 0; b < image_.set().NumBlocks(); ++b) {
        all.push_back(static_cast<std::int32_t>(b));
      }
      Add(MakeGramCostFunction(image_, state), all.data(), all.size());
      return;
    }
    const SupportRoots& roots = image_.roots();
    for (std::size_t i = 0; i < roots.panels().size(); ++i) {
      const RootPanel& panel = roots.panels()[i];
      Add(MakePanelCostFunction(image_, state, i),
          roots.supports()[static_cast<std::size_t>(panel.support)].blocks.data() +
              panel.first_block,
          static_cast<std::size_t>(panel.num_blocks));
    }
    const std::int32_t block = 0;
    Add(MakeRestCostFunction(image_, state, block), &block, 1);
  }

  void AddPriors(const std::vector<PriorTerm>& terms) {
    for (const PriorTerm& term : terms) {
      Add(MakePriorCostFunction(term, image_.set()),
          term.blocks.data(),
          term.blocks.size(),
          MakePriorLossFunction(term));
    }
  }

  void SetBounds() {
    const ParameterSet& set = image_.set();
    for (std::size_t b = 0; b < used_.size(); ++b) {
      const auto block = static_cast<std::int32_t>(b);
      for (int c = 0; used_[b] != 0 && c < set.BlockSize(block); ++c) {
        const std::size_t scalar = set.BlockOffset(block) + static_cast<std::size_t>(c);
        double* pointer = theta_.data() + set.BlockOffset(block);
        const auto [lower, upper] = BoundsOfStep(set, theta_, scalar);
        if (std::isfinite(lower)) {
          problem_.SetParameterLowerBound(pointer, c, lower);
        }
        if (std::isfinite(upper)) {
          problem_.SetParameterUpperBound(pointer, c, upper);
        }
      }
    }
  }

  [[nodiscard]] int num_rows() const { return num_rows_; }

 private:
  const ImageProblem& image_;
  std::vector<double>& theta_;
  ceres::Problem& problem_;
  std::vector<char> used_;
  std::vector<double*> pointers_;
  int num_rows_ = 0;
};

ceres::Solver::Options MakeSolverOptions(const SolveOptions& options, int num_rows) {
  ceres::Solver::Options solver;
  solver.initial_trust_region_radius = options.radius;
  solver.max_trust_region_radius = options.radius;
  solver.max_num_iterations = kMaxRejections + 1;
  solver.max_num_consecutive_invalid_steps = kMaxRejections + 2;
  solver.function_tolerance = 0.0;
  solver.gradient_tolerance = 0.0;
  solver.parameter_tolerance = 0.0;
  // Otherwise any bound, even an inactive one, asks for Jacobians at trial points.
  solver.max_num_line_search_step_size_iterations = 0;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  switch (options.linear_solver) {
    case LinearSolverKind::kGram:
      solver.linear_solver_type =
          num_rows <= kMaxDenseRows ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
      break;
    case LinearSolverKind::kCholesky:
      solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
      break;
    case LinearSolverKind::kSparseGram:  // not of this solver
    case LinearSolverKind::kCgnr:
      solver.linear_solver_type = ceres::CGNR;
      solver.preconditioner_type = ceres::JACOBI;
      solver.eta = options.eta;
      solver.max_linear_solver_iterations = kMaxConjugateSteps;
      break;
  }
  return solver;
}

}  // namespace

std::string CeresVersion() { return CERES_VERSION_STRING; }

LinearSolverKind SolverOfRows(LinearSolverChoice choice,
                              const ProblemSize& size,
                              double max_bytes) {
  const LinearSolverKind kind = choice == LinearSolverChoice::kCholesky
                                    ? LinearSolverKind::kCholesky
                                    : LinearSolverKind::kCgnr;
  CheckFits(size, kind, max_bytes);
  return kind;
}

SolveOutcome SolveRound(ImageProblem& problem,
                        const std::vector<PriorTerm>& priors,
                        const std::vector<PriorTerm>& proximal,
                        const std::vector<double>& theta,
                        const SolveOptions& options) {
  if (options.linear_solver == LinearSolverKind::kSparseGram) {
    return SolveSparseRound(problem, priors, proximal, theta, options);
  }
  openblas_set_num_threads(1);
  const SilenceLog silence;
  const auto start = renderer::Clock::now();
  SolveOutcome outcome;
  outcome.theta = theta;
  std::vector<double> moving = theta;
  EvaluationState state;
  RenderCallback render(problem, moving, options, state);
  StopAfterStep stop(render, outcome);

  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &render;
  problem_options.disable_all_safety_checks = true;
  ceres::Problem ceres_problem(problem_options);
  ProblemBuilder builder(problem, moving, ceres_problem);
  builder.AddImages(state);
  builder.AddPriors(priors);
  builder.AddPriors(proximal);
  builder.SetBounds();

  ceres::Solver::Options solver_options = MakeSolverOptions(options, builder.num_rows());
  solver_options.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options, &ceres_problem, &summary);
  if (render.error()) {
    std::rethrow_exception(render.error());
  }
  if (summary.termination_type == ceres::FAILURE) {
    if (summary.iterations.empty()) {
      throw renderer::NumericalError("the solver cannot begin a round: " + summary.message);
    }
    outcome.failure = summary.message;
  }
  if (outcome.accepted) {
    outcome.theta = render.trial();
  }
  outcome.trials = render.trials();
  outcome.refused = render.refused();
  // After each rejection the radius is divided by twice the last divisor.
  outcome.radius = options.radius;
  for (int k = 1, divisor = 2; k < outcome.trials; ++k, divisor *= 2) {
    outcome.radius /= divisor;
  }
  outcome.render_s = render.seconds();
  outcome.linear_s = renderer::SecondsSince(start) - outcome.render_s;
  return outcome;
}

}  // namespace pathfit::optim
