#include "optim/problem/image_problem.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace pathfit::optim {
namespace {

// Of a view while it is linearised: two films, the weights of its rows, its photo and masks
// unpacked, its pixels' costs.
constexpr double kBytesPerPixel =
    2.0 * sizeof(renderer::Rgba) + sizeof(RowScales::value_type) + 7.0 * sizeof(float);
// Standard errors from which on a comparison decides.
constexpr double kSure = 3.0;
// A step that promises a larger share of the cost may lead out of the model, however noisy it is.
constexpr double kSmallDecrease = 0.1;
// Variance of a trial's cost, over the start's and over the square of the predicted decrease.
constexpr double kBlinding = 100.0;

/// One half of a view's linearisation.
struct Half {
  /// `by_terms`: until JoinTerms its derivatives are in `terms`.
  Half(const ImageSource& source,
       int view,
       const SampleSet& samples,
       const ViewLevel& level,
       bool by_terms)
      : sink(level.photo.width, level.photo.height), terms(level.photo.width, level.photo.height) {
    if (by_terms) {
      film = source.RenderDerivative(view, samples, terms);
      terms.Finish();
    } else {
      film = source.RenderDerivative(view, samples, sink);
      sink.Finish();
    }
    bytes = sink.MemoryBytes() + terms.MemoryBytes();
  }
  void JoinTerms() { terms.MoveTo(sink); }

  renderer::Film film;
  JacobianSink sink;
  TermSink terms;
  std::size_t bytes = 0;  ///< of the derivatives, at most
};

}  // namespace

double ImageProblem::BytesOfView(const PackedLevel& level, const LossSpec& loss, bool uses_gram) {
  const double pixels = static_cast<double>(level.camera().width) * level.camera().height;
  const double kept = (level.HasClipped() ? 1.0 : 0.0) + (loss.robust_huber > 0.0 ? 1.0 : 0.0) +
                      (uses_gram ? sizeof(float) : 0.0);
  return static_cast<double>(level.MemoryBytes()) + kept * pixels;
}

ImageProblem::ImageProblem(ImageSource& source,
                           const FitViews& views,
                           const ParameterSet& set,
                           const ImageProblemOptions& options)
    : source_(source),
      views_(views),
      set_(set),
      options_(options),
      fitted_(options.fitted != nullptr ? *options.fitted : views.fitted),
      uses_gram_(FormsNormalEquations(options.linear_solver, set.NumScalars())),
      uses_sparse_gram_(FormsSparseNormalEquations(options.linear_solver, set.NumScalars())),
      split_meter_(options.num_measured > 0 ? SplitMeter(set) : SplitMeter()) {
  size_.num_scalars = static_cast<double>(set.NumScalars());
  if (uses_gram_) {
    size_.row_history_bytes =
        RoundSums::BytesOfRows(views, 1.0, set.NumScalars(), options.max_memory_bytes);
    keeps_rows_ = size_.row_history_bytes > 0.0;
  }
  if (uses_sparse_gram_) {
    size_.num_spread_scalars = static_cast<double>(PairedBlocks(set).NumSpreadScalars());
    size_.sparse_gram_empty = static_cast<double>(SparseGram::BytesOfEmpty(set));
  } else if (!uses_gram_) {
    roots_.emplace(set, std::max(fitted_.size(), options.expected_views));
  }
  for (const int view : fitted_) {
    size_.images_bytes +=
        BytesOfView(views.levels[static_cast<std::size_t>(view)], options_.loss, uses_gram_);
  }
}

/// What one view adds to sums.
struct ImageProblem::ViewSums {
  GradientSums sums;
  std::optional<SplitMeter> meter;      ///< of a view that is measured
  std::optional<QuadraticModel> model;  ///< with normal equations
  ViewQuality quality;
  ImageCosts costs;
  double bytes = 0.0;  ///< while it was linearised

  static void VisitParts(auto& view, const auto& visit) {
    visit(view.sums.gradient);
    visit(view.sums.diagonal);
    visit(view.meter);
    visit(view.model);
    visit(view.quality);
    visit(view.costs);
    visit(view.bytes);
  }
};

/// Rows of a view, or behind them what it adds to sums.
struct ImageProblem::LinearizedPart {
  PixelRows rows;
  std::optional<ViewSums> sums;

  static void VisitParts(auto& part, const auto& visit) {
    visit(part.rows.units);
    visit(part.rows.entries);
    visit(part.rows.spreads);
    visit(part.sums);
  }
};

struct ImageProblem::TrialCosts {
  ImageCosts costs;
  double paired_variance = 0.0;
};

void ImageProblem::Linearize(const std::vector<double>& values) {
  if (uses_gram_) {
    CheckFits(size_, LinearSolverKind::kGram, options_.max_memory_bytes);
    round_model_ = QuadraticModel(set_.NumScalars());
    start_pixel_costs_.resize(fitted_.size());
    if (keeps_rows_) round_rows_.resize(fitted_.size());
  }
  if (uses_sparse_gram_) {
    CheckFits(size_, LinearSolverKind::kSparseGram, options_.max_memory_bytes);
    sparse_gram_ = SparseGram(set_);
    if (options_.draws_gradients) {
      gradient_draws_ = GradientDraws(set_.NumScalars(), options_.samples.a.seed);
    }
  }
  source_.SetValues(values);
  sums_ = GradientSums(set_.NumScalars());
  costs_ = {};
  trust_.resize(fitted_.size());
  rank_of_ = division().DealItems(Division::Kind::kDerivative, fitted_);
  division().ForEach<LinearizedPart>(
      Division::Kind::kDerivative,
      rank_of_,
      [&](std::size_t i, const auto& give) { LinearizeView(i, values, give); },
      [&](std::size_t i, const LinearizedPart& part) { TakeLinearized(i, part); });
  if (!division().IsFirst()) {
    return;
  }
  if (uses_gram_) {
    MakeNormalEquations(values);
  } else if (uses_sparse_gram_) {
    sparse_gram_.Deflate(options_.draws_gradients ? std::vector<double>() : sums_.gradient);
  } else {
    roots_->Finish();
    if (options_.expected_views <= fitted_.size()) {
      size_.roots = roots_->Size();
    }
    offset_squared_ = roots_->residual_squared() + costs_.noise_squared + 1e-12;
  }
}

void ImageProblem::TakeLinearized(std::size_t index, const LinearizedPart& part) {
  for (; roots_ && num_begun_ <= index; ++num_begun_) {
    roots_->BeginView();
  }
  if (!part.sums) {
    if (keeps_rows_) {
      round_rows_[index].Append(part.rows);
    } else if (uses_sparse_gram_) {
      sparse_gram_.Add(part.rows);
      if (!gradient_draws_.Empty()) gradient_draws_.Add(part.rows, set_, index);
    } else {
      roots_->Add(part.rows);
    }
    return;
  }
  sums_.Add(part.sums->sums);
  if (part.sums->meter) split_meter_.Add(*part.sums->meter);
  if (part.sums->model) round_model_.AddViews(*part.sums->model);
  quality_.push_back(part.sums->quality);
  costs_.Add(part.sums->costs);
  size_.largest_view_bytes = std::max(size_.largest_view_bytes, part.sums->bytes);
  LinearSolverKind least = LinearSolverKind::kCgnr;
  if (uses_gram_) {
    least = LinearSolverKind::kGram;
  } else if (uses_sparse_gram_) {
    least = LinearSolverKind::kSparseGram;
    size_.sparse_gram_bytes = static_cast<double>(sparse_gram_.MemoryBytes());
    size_.sparse_gram_seen = static_cast<double>(sparse_gram_.NumSeen());
  } else {
    size_.roots = roots_->Size();
  }
  sizes_.push_back(size_);
  CheckFits(size_, least, options_.max_memory_bytes);
}

void ImageProblem::MakeNormalEquations(const std::vector<double>& values) {
  start_theta_ = set_.ThetaFromValues(values);
  start_costs_ = costs_;
  round_model_.HoldAxes(set_);
  round_model_.FinishRound(start_theta_, sums_.gradient);
  rounds_ = options_.earlier != nullptr ? *options_.earlier : RoundSums();
  rounds_.Add(round_model_, round_rows_, start_theta_, options_.weight, set_);
  round_rows_ = {};
  std::vector<bool> is_log(set_.NumScalars());
  for (std::size_t i = 0; i < is_log.size(); ++i) {
    is_log[i] = set_.IsLog(i);
  }
  at_start_ = MakeModelAtPoint(rounds_.model, start_theta_, is_log);
  gram_root_ = MakeGramRoot(
      at_start_.hessian, at_start_.gradient, costs_.signal_squared, costs_.noise_squared);
}

bool ImageProblem::IsMeasured(std::size_t index) const {
  const std::size_t count = fitted_.size();
  const std::size_t turned = (index + options_.first_measured) % count;
  // One of each run of views, as many as wanted.
  return turned * options_.num_measured / count != (turned + 1) * options_.num_measured / count;
}

void ImageProblem::LinearizeView(std::size_t index,
                                 const std::vector<double>& values,
                                 const std::function<void(const LinearizedPart&)>& give) {
  const int view = fitted_[index];
  const ViewLevel level = views_.levels[static_cast<std::size_t>(view)].Unpack();
  const std::string& name = views_.names[static_cast<std::size_t>(view)];
  const bool is_measured = IsMeasured(index);
  Half half_a(source_, view, options_.samples.a, level, is_measured);
  Half half_b(source_, view, options_.samples.b, level, is_measured);
  const renderer::Film& a = half_a.film;
  const renderer::Film& b = half_b.film;
  CheckFinite(a, name);
  CheckFinite(b, name);
  trust_[index] = JudgePixels(level, options_.loss, a, b);
  const RowScales scales = MakeRowScales(level, views_.silhouettes, options_.loss, trust_[index]);
  ViewSums sums;
  sums.sums = GradientSums(set_.NumScalars());
  sums.quality = MeasureView(level, a, b, views_.silhouettes);
  if (is_measured) {
    sums.meter.emplace(set_).AddTerms(
        {a, b, half_a.terms, half_b.terms, level, scales, values, name});
    half_a.JoinTerms();
    half_b.JoinTerms();
  }
  if (uses_gram_) {
    sums.model.emplace(set_.NumScalars());
  }
  double rows_bytes = 0.0;
  HalvesMerger merger(
      {a, b, half_a.sink, half_b.sink}, level, scales, set_, values, name, keeps_rows_);
  LinearizedPart part;
  while (merger.HasNext()) {
    PixelRows& rows = part.rows;
    merger.Next(rows);
    rows_bytes = std::max(rows_bytes, static_cast<double>(rows.MemoryBytes()));
    sums.sums.Add(rows, set_);
    if (sums.meter) {
      sums.meter->AddRows(rows);
    }
    if (sums.model) {
      sums.model->AddRows(rows, set_);
    }
    if (!sums.model || keeps_rows_) {
      give(part);
    }
  }
  sums.bytes = rows_bytes + kBytesPerPixel * static_cast<double>(scales.size()) +
               static_cast<double>(half_a.bytes + half_b.bytes);
  std::vector<float> pixel_costs = AddSplitHalfCosts(level, scales, a, b, sums.costs);
  if (uses_gram_) {
    start_pixel_costs_[index] = std::move(pixel_costs);
  }
  part = {{}, std::move(sums)};
  give(part);
}

void ImageProblem::RenderTrial(const std::vector<double>& values) {
  source_.SetValues(values);  // where it throws there is no trial
  division().Share(values);
  RenderTrialViews();
}

void ImageProblem::EndTrials() { division().Share(std::vector<double>()); }

void ImageProblem::FollowTrials() {
  for (;;) {
    const std::vector<double> values = division().Share(std::vector<double>());
    if (values.empty()) {
      return;
    }
    source_.SetValues(values);
    RenderTrialViews();
  }
}

void ImageProblem::RenderTrialViews() {
  costs_ = {};
  paired_variance_ = 0.0;
  division().ForEach<TrialCosts>(
      Division::Kind::kTrial,
      rank_of_,
      [&](std::size_t i, const auto& give) { give(RenderTrialView(i)); },
      [&](std::size_t, const TrialCosts& trial) {
        costs_.Add(trial.costs);
        paired_variance_ += trial.paired_variance;
      });
}

ImageProblem::TrialCosts ImageProblem::RenderTrialView(std::size_t index) {
  const int view = fitted_[index];
  const std::string& name = views_.names[static_cast<std::size_t>(view)];
  const renderer::Film a = source_.RenderPrimal(view, options_.samples.a);
  CheckFinite(a, name);
  const renderer::Film b = source_.RenderPrimal(view, options_.samples.b);
  CheckFinite(b, name);
  const ViewLevel level = views_.levels[static_cast<std::size_t>(view)].Unpack();
  const RowScales scales = MakeRowScales(level, views_.silhouettes, options_.loss, trust_[index]);
  TrialCosts trial;
  const std::vector<float> costs = AddSplitHalfCosts(level, scales, a, b, trial.costs);
  for (std::size_t p = 0; uses_gram_ && p < costs.size(); ++p) {
    const auto change =
        static_cast<double>(costs[p]) - static_cast<double>(start_pixel_costs_[index][p]);
    trial.paired_variance += change * change;
  }
  return trial;
}

void ImageProblem::EvalTrial(const std::vector<double>& values) {
  if (uses_gram_) {
    EvalTrialByModel(values);
  } else {
    RenderTrial(values);
  }
}

void ImageProblem::EvalTrialByModel(const std::vector<double>& values) {
  const std::size_t n = set_.NumScalars();
  std::vector<double> step = set_.ThetaFromValues(values);
  for (std::size_t i = 0; i < n; ++i) {
    step[i] -= start_theta_[i];
  }
  const auto form = [&](const std::vector<double>& matrix) {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        sum += step[i] * matrix[i * n + j] * step[j];
      }
    }
    return sum;
  };
  double decrease = -0.5 * form(at_start_.hessian);
  for (std::size_t i = 0; i < n; ++i) {
    decrease -= at_start_.gradient[i] * step[i];
  }
  const double variance = std::max(0.0, form(round_model_.covariance));
  ImageCosts predicted = start_costs_;
  predicted.colors -= decrease;
  predicted.signal_squared -= 2.0 * decrease;
  const bool is_small = decrease <= kSmallDecrease * std::abs(start_costs_.Total());
  if (is_small && std::abs(decrease) <= kSure * std::sqrt(variance)) {
    costs_ = predicted;
    return;
  }
  RenderTrial(values);
  const double measured = start_costs_.Total() - costs_.Total();
  // Both bound the comparison's noise from above: what moved may be noise in the first, nothing
  // that the samples have in common cancels in the second.
  const double noise = std::min(paired_variance_, start_costs_.variance + costs_.variance);
  if (std::abs(measured - decrease) > kSure * std::sqrt(noise)) {
    return;
  }
  // Such as a mirror that shows a small lamp: where noise drowns all, nothing says whether the
  // model still holds there, and the next rounds would learn little.
  const bool is_blind = costs_.variance > kBlinding * start_costs_.variance &&
                        costs_.variance > kBlinding * decrease * decrease;
  costs_ = is_blind ? start_costs_ : predicted;
  if (is_blind) {
    costs_.colors += std::abs(decrease);
    costs_.signal_squared += 2.0 * std::abs(decrease);
  }
}

}  // namespace pathfit::optim
