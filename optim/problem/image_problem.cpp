#include "optim/problem/image_problem.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pathfit::optim {
namespace {

// Standard errors from which on a comparison decides.
constexpr double kSure = 3.0;
// A step that promises a larger share of the cost may lead out of the model, however noisy it is.
constexpr double kSmallDecrease = 0.1;

}  // namespace

ImageProblem::ImageProblem(ImageSource& source,
                           const FitViews& views,
                           const ParameterSet& set,
                           const ImageProblemOptions& options)
    : source_(source),
      views_(views),
      set_(set),
      options_(options),
      uses_gram_(FormsNormalEquations(options.linear_solver, set.NumScalars())) {
  size_.num_scalars = static_cast<double>(set.NumScalars());
  for (const int view : views.fitted) {
    const ViewLevel& level = views.levels[static_cast<std::size_t>(view)];
    size_.images_bytes += 21.0 * static_cast<double>(level.color_weight.data.size());
  }
}

void ImageProblem::Linearize(const std::vector<double>& values) {
  if (uses_gram_) {
    CheckFits(size_, LinearSolverKind::kGram, options_.max_memory_bytes);
    round_model_ = QuadraticModel(set_.NumScalars());
    start_pixel_costs_.clear();
  }
  source_.SetValues(values);
  sums_ = GradientSums(set_.NumScalars());
  costs_ = {};
  for (std::size_t i = 0; i < views_.fitted.size(); ++i) {
    LinearizeView(i, values);
    const LinearSolverKind least = uses_gram_ ? LinearSolverKind::kGram : LinearSolverKind::kCgnr;
    CheckFits(size_.Extrapolated(i + 1, views_.fitted.size()), least, options_.max_memory_bytes);
  }
  if (uses_gram_) {
    MakeNormalEquations(values);
  }
  for (ResidualGroups& groups : view_groups_) {
    groups.FixOffsets();
  }
  // The constant pixels' half sum may be negative by noise; the offset keeps its root real.
  rest_offset_squared_ = 1e3 * (costs_.signal_squared + costs_.noise_squared) + 1e-12;
}

void ImageProblem::MakeNormalEquations(const std::vector<double>& values) {
  start_theta_ = set_.ThetaFromValues(values);
  start_costs_ = costs_;
  round_model_.FinishRound(start_theta_, sums_.gradient);
  model_ = options_.earlier != nullptr ? *options_.earlier : QuadraticModel();
  Accumulate(round_model_, start_theta_, options_.weight, model_);
  at_start_ = MakeModelAtPoint(model_, start_theta_);
  gram_root_ = MakeGramRoot(
      at_start_.hessian, at_start_.gradient, costs_.signal_squared, costs_.noise_squared);
}

PixelRows ImageProblem::RenderRows(std::size_t index,
                                   const std::vector<double>& values,
                                   renderer::Film& a,
                                   renderer::Film& b) {
  const int view = views_.fitted[index];
  const auto& level = views_.levels[static_cast<std::size_t>(view)];
  JacobianSink sink_a(level.photo.width, level.photo.height);
  a = source_.RenderDerivative(view, options_.samples.a, sink_a);
  sink_a.Finish();
  JacobianSink sink_b(level.photo.width, level.photo.height);
  b = source_.RenderDerivative(view, options_.samples.b, sink_b);
  sink_b.Finish();
  scales_.push_back(MakeRowScales(views_, view, options_.loss, AverageFilm(a, b)));
  PixelRows rows = MergeHalves({a, b, sink_a, sink_b},
                               level,
                               scales_.back(),
                               set_,
                               values,
                               views_.names[static_cast<std::size_t>(view)],
                               uses_gram_);
  const double bytes = static_cast<double>(
      rows.entries.size() * sizeof(RowEntry) + rows.spreads.size() * sizeof(EntrySpread) +
      rows.units.size() * sizeof(RowUnit) + sink_a.MemoryBytes() + sink_b.MemoryBytes());
  size_.largest_view_bytes = std::max(size_.largest_view_bytes, bytes);
  return rows;
}

void ImageProblem::LinearizeView(std::size_t index, const std::vector<double>& values) {
  const auto& level = views_.levels[static_cast<std::size_t>(views_.fitted[index])];
  renderer::Film a, b;
  PixelRows rows = RenderRows(index, values, a, b);
  const renderer::Film average = AverageFilm(a, b);
  use_.push_back(std::move(rows.use));
  quality_.push_back(MeasureView(level, average, views_.silhouettes));
  sums_.Add(rows, level, scales_.back(), average, set_);
  if (uses_gram_) {
    round_model_.AddRows(rows, set_);
  } else {
    view_groups_.push_back(ResidualGroups::Build(rows, set_));
    AddSize(view_groups_.back());
  }
  std::vector<float> pixel_costs = AddCosts(index, a, b);
  if (uses_gram_) {
    start_pixel_costs_.push_back(std::move(pixel_costs));
  }
}

void ImageProblem::AddSize(const ResidualGroups& groups) {
  size_.num_groups += static_cast<double>(groups.groups().size());
  size_.num_rows += static_cast<double>(groups.u.size());
  size_.group_blocks += static_cast<double>(groups.blocks().size());
  size_.jacobian_cells += static_cast<double>(groups.cells().size());
  for (const ResidualGroup& group : groups.groups()) {
    double columns = 0.0;
    for (std::int32_t k = 0; k < group.num_blocks; ++k) {
      columns += set_.BlockSize(groups.blocks()[group.first_block + static_cast<std::size_t>(k)]);
    }
    size_.product_cells += 0.5 * group.num_blocks * (group.num_blocks + 1.0);
    size_.product_flops += (group.num_rows + 1.0) * columns * columns;
  }
}

std::vector<float> ImageProblem::AddCosts(std::size_t index,
                                          const renderer::Film& a,
                                          const renderer::Film& b) {
  const ViewLevel& level = views_.levels[static_cast<std::size_t>(views_.fitted[index])];
  const RowScales& scales = scales_[index];
  std::vector<float> pixel_costs = AddSplitHalfCosts(level, scales, a, b, use_[index], costs_);
  if (uses_gram_) {
    return pixel_costs;
  }
  ResidualGroups& groups = view_groups_[index];
  for (std::size_t row = 0; row < groups.u.size(); ++row) {
    const auto source = static_cast<std::size_t>(groups.row_sources()[row]);
    const std::size_t p = source / 4;
    const std::size_t channel = source % 4;
    const double r_a = PixelResidual(level, scales[p], a.pixels[p], p)[channel];
    const double r_b = PixelResidual(level, scales[p], b.pixels[p], p)[channel];
    groups.u[row] = 0.5 * (r_a + r_b);
    groups.v[row] = 0.5 * (r_a - r_b);
  }
  return pixel_costs;
}

void ImageProblem::RenderTrial(const std::vector<double>& values) {
  source_.SetValues(values);
  costs_ = {};
  paired_variance_ = 0.0;
  for (std::size_t i = 0; i < views_.fitted.size(); ++i) {
    const int view = views_.fitted[i];
    const std::string& name = views_.names[static_cast<std::size_t>(view)];
    const renderer::Film a = source_.RenderPrimal(view, options_.samples.a);
    CheckFinite(a, name);
    const renderer::Film b = source_.RenderPrimal(view, options_.samples.b);
    CheckFinite(b, name);
    const std::vector<float> costs = AddCosts(i, a, b);
    if (uses_gram_) {
      for (std::size_t p = 0; p < costs.size(); ++p) {
        const auto change =
            static_cast<double>(costs[p]) - static_cast<double>(start_pixel_costs_[i][p]);
        paired_variance_ += change * change;
      }
    }
  }
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
  if (std::abs(measured - decrease) <= kSure * std::sqrt(noise)) {
    costs_ = predicted;
  }
}

}  // namespace pathfit::optim
