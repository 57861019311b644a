#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/fit_views.h"
#include "optim/problem/gradient_draws.h"
#include "optim/problem/gram_system.h"
#include "optim/problem/image_source.h"
#include "optim/problem/problem_size.h"
#include "optim/problem/round_sums.h"
#include "optim/problem/sample_split.h"
#include "optim/problem/sparse_gram.h"
#include "optim/problem/split_half_cost.h"
#include "optim/problem/support_roots.h"
#include "optim/problem/view_quality.h"
#include "optim/ranks/division.h"

namespace pathfit::optim {

struct ImageProblemOptions {
  /// Views to fit; null: those of the views. Must outlive the problem.
  const std::vector<int>* fitted = nullptr;
  LossSpec loss;
  LinearSolverChoice linear_solver = LinearSolverChoice::kAuto;
  double max_memory_bytes = 0.0;
  SampleHalves samples;
  /// The stage's earlier rounds, for normal equations; null: none. Must outlive the problem.
  const RoundSums* earlier = nullptr;
  double weight = 1.0;  ///< of this round beside the earlier ones
  /// Of how many views, spread evenly from `first_measured` on, terms are measured (split_meter()).
  std::size_t num_measured = 0, first_measured = 0;
  /// More than are fitted: the size is that of a problem with so many views like these.
  std::size_t expected_views = 0;
  /// Whether the sparse normal equations are for standard errors: with draws of their gradient, and
  /// without all that noise adds.
  bool draws_gradients = false;
  /// Among whom views are divided; null: nobody. Must outlive the problem.
  Division* division = nullptr;
};

/// The photos' part of one round's least-squares problem: everything random fixed, linearised once
/// at the round's start and re-rendered (same samples) at trial points. On ranks other than the
/// first it renders what they are dealt, and knows of no results.
class ImageProblem {
 public:
  /// All arguments must outlive the problem.
  ImageProblem(ImageSource& source,
               const FitViews& views,
               const ParameterSet& set,
               const ImageProblemOptions& options);

  /// Renders derivatives of every fitted view with both halves at `values` and keeps either the
  /// roots or the normal equations. Throws MemoryError before the memory is taken,
  /// renderer::NumericalError, renderer::Cancelled.
  void Linearize(const std::vector<double>& values);

  /// Renders both halves at `values`; afterwards costs() are those of the trial. With normal
  /// equations a rendering decides only where it can: costs() are those of the quadratic model
  /// where its decrease is small and drowns in the noise of such a comparison (then nothing is
  /// rendered), and where the rendering does not contradict it; unless it could not, for noise that
  /// the start has not: such a trial has a higher cost than the start.
  void EvalTrial(const std::vector<double>& values);
  /// Of other ranks than the first: renders its trials until it ends them.
  void FollowTrials();
  /// Of the first rank: there are no more trials.
  void EndTrials();

  [[nodiscard]] bool UsesGram() const { return uses_gram_; }
  [[nodiscard]] const ParameterSet& set() const { return set_; }
  [[nodiscard]] const ImageCosts& costs() const { return costs_; }
  /// Whether J^T J is kept sparsely instead of roots.
  [[nodiscard]] bool UsesSparseGram() const { return uses_sparse_gram_; }
  /// Of this round's photos, to be used up; empty unless UsesSparseGram.
  [[nodiscard]] SparseGram TakeSparseGram() { return std::move(sparse_gram_); }
  /// J^T r of this round's photos, to be used up with the former.
  [[nodiscard]] std::vector<double> TakeGradient() { return std::move(sums_.gradient); }
  /// Empty unless asked for.
  [[nodiscard]] std::vector<std::vector<double>> TakeGradientDraws() {
    return gradient_draws_.Take();
  }
  /// Unless normal equations, dense or sparse, are used.
  [[nodiscard]] const SupportRoots& roots() const { return *roots_; }
  [[nodiscard]] const GramRoot& gram() const { return gram_root_; }
  /// Of this and the earlier rounds; empty without normal equations.
  [[nodiscard]] const QuadraticModel& model() const { return rounds_.model; }
  /// The same with what it is made of, to be used up.
  [[nodiscard]] RoundSums TakeRounds() { return std::move(rounds_); }
  [[nodiscard]] const GradientSums& sums() const { return sums_; }
  [[nodiscard]] const ProblemSize& size() const { return size_; }
  /// The same as it was after each view.
  [[nodiscard]] const std::vector<ProblemSize>& sizes() const { return sizes_; }
  /// Of the fitted views, from the linearisation's own renderings.
  [[nodiscard]] const std::vector<ViewQuality>& quality() const { return quality_; }
  [[nodiscard]] const SplitMeter& split_meter() const { return split_meter_; }
  /// C^2 of the roots' row of what no parameter explains: twice the cost and this is the sum of
  /// the squares of all residuals.
  [[nodiscard]] double offset_squared() const { return offset_squared_; }

  /// Memory of a fitted view's images beside its photo, with what is kept for each pixel.
  static double BytesOfView(const PackedLevel& level, const LossSpec& loss, bool uses_gram);

  /// Above this many free scalars the normal equations are not formed densely unless asked for.
  static constexpr std::size_t kMaxGramScalars = 500;
  static bool FormsNormalEquations(LinearSolverChoice choice, std::size_t num_scalars) {
    return choice == LinearSolverChoice::kGram ||
           (choice == LinearSolverChoice::kAuto && num_scalars <= kMaxGramScalars);
  }
  /// Many unknowns keep the pairs of them that meet in pixels unless rows are asked for.
  static bool FormsSparseNormalEquations(LinearSolverChoice choice, std::size_t num_scalars) {
    return choice == LinearSolverChoice::kSparseGram ||
           (choice == LinearSolverChoice::kAuto && !FormsNormalEquations(choice, num_scalars));
  }

 private:
  struct ViewSums;
  struct LinearizedPart;
  struct TrialCosts;

  Division& division() { return options_.division != nullptr ? *options_.division : alone_; }
  /// On the rank that renders it.
  void LinearizeView(std::size_t index,
                     const std::vector<double>& values,
                     const std::function<void(const LinearizedPart&)>& give);
  TrialCosts RenderTrialView(std::size_t index);
  /// On the first rank.
  void TakeLinearized(std::size_t index, const LinearizedPart& part);
  [[nodiscard]] bool IsMeasured(std::size_t index) const;
  void MakeNormalEquations(const std::vector<double>& values);
  void RenderTrial(const std::vector<double>& values);
  void RenderTrialViews();
  void EvalTrialByModel(const std::vector<double>& values);

  ImageSource& source_;
  const FitViews& views_;
  const ParameterSet& set_;
  ImageProblemOptions options_;
  const std::vector<int>& fitted_;
  bool uses_gram_, uses_sparse_gram_;
  bool keeps_rows_ = false;  // of all rounds

  Division alone_;
  std::vector<int> rank_of_;   // by fitted view: who renders it, trials too
  std::size_t num_begun_ = 0;  // views of which rows were taken
  // By fitted view, where it is rendered: JudgePixels.
  std::vector<PixelTrust> trust_;
  std::vector<ViewQuality> quality_;  // by fitted view
  SplitMeter split_meter_;
  std::optional<SupportRoots> roots_;  // unless there are normal equations
  SparseGram sparse_gram_;
  GradientDraws gradient_draws_;
  GradientSums sums_;
  std::vector<double> start_theta_;
  QuadraticModel round_model_;
  std::vector<PixelRows> round_rows_;  // by fitted view, where rows are summed over rounds
  RoundSums rounds_;
  ModelAtPoint at_start_;
  GramRoot gram_root_;
  ImageCosts costs_, start_costs_;
  std::vector<std::vector<float>> start_pixel_costs_;  // of normal equations, where rendered
  double paired_variance_ = 0.0;  // of the trial's change of cost, as if all of it were noise
  ProblemSize size_;
  std::vector<ProblemSize> sizes_;
  double offset_squared_ = 0.0;
};

}  // namespace pathfit::optim
