#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/fit_views.h"
#include "optim/problem/pixel_rows.h"
#include "renderer/render_options.h"

namespace pathfit::optim {

/// Measures what each term of the derivative adds to the error of a step, and finds the split of
/// samples that makes the error least for its cost: samples as the root of variance over cost
/// (Neyman's allocation of a stratified sample). The variance is that of the photos' gradient, each
/// scalar in units of its curvature, summed; the cost a number of paths, never a time, so that the
/// split is a function of the samples alone.
class SplitMeter {
 public:
  SplitMeter() = default;
  explicit SplitMeter(const ParameterSet& set);

  /// Both halves of a view, their derivatives by terms.
  struct View {
    const renderer::Film &film_a, &film_b;
    const TermSink &terms_a, &terms_b;
    const ViewLevel& level;
    const RowScales& scales;
    const std::vector<double>& values;
    const std::string& name;
  };
  void AddTerms(const View& view);
  /// Rows of all terms together, of the same views, with spreads.
  void AddRows(const PixelRows& rows);

  /// What other views have added to another meter of the same unknowns.
  void Add(const SplitMeter& other);
  static void VisitParts(auto& meter, const auto& visit) {
    visit(meter.terms_);
    visit(meter.image_variance_);
    visit(meter.square_);
    visit(meter.difference_square_);
  }

  /// Halfway, as factors, from the split in use to the best one for what was measured; terms
  /// without samples keep theirs. With `at_cost_of`, all boundary terms together cost what they
  /// would with its budgets; else no more than three times the interior.
  [[nodiscard]] renderer::SampleBudget Improve(
      const renderer::SampleBudget& used,
      const std::optional<renderer::SampleBudget>& at_cost_of = {}) const;

 private:
  struct Term {
    std::vector<double> variance;  ///< of the gradient, by scalar
    double num_samples = 0.0;

    static void VisitParts(auto& term, const auto& visit) {
      visit(term.variance);
      visit(term.num_samples);
    }
  };
  const ParameterSet* set_ = nullptr;
  std::array<Term, renderer::kNumDerivativeTerms> terms_;
  std::vector<double> image_variance_;  ///< of the gradient by the noise of images
  std::vector<double> square_,
      difference_square_;  ///< of J: of the halves' mean, and what is noise
};

}  // namespace pathfit::optim
