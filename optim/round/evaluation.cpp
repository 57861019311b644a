#include "optim/round/evaluation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "optim/problem/pixel_rows.h"
#include "optim/problem/split_half_cost.h"
#include "optim/round/exposure_gauge.h"
#include "optim/round/round_policy.h"

namespace pathfit::optim {
namespace {

constexpr double kSure = 3.0;  // standard errors

void Average(StageReport& report) {
  double fit = 0.0, val = 0.0;
  for (const ViewReport& view : report.views) {
    (view.validation ? val : fit) += 1.0;
  }
  const double none = std::numeric_limits<double>::quiet_NaN();
  report.psnr_srgb_fit = report.psnr_linear_fit = report.iou_fit = fit > 0.0 ? 0.0 : none;
  report.psnr_srgb_val = report.psnr_linear_val = report.iou_val = val > 0.0 ? 0.0 : none;
  for (const ViewReport& view : report.views) {
    const double count = view.validation ? val : fit;
    (view.validation ? report.psnr_srgb_val : report.psnr_srgb_fit) += view.psnr_srgb / count;
    (view.validation ? report.psnr_linear_val : report.psnr_linear_fit) += view.psnr_linear / count;
    (view.validation ? report.iou_val : report.iou_fit) += view.iou / count;
  }
}

}  // namespace

EvaluatedCost EvaluateCost(const ImageSource& source,
                           const FitViews& views,
                           const LossSpec& loss,
                           const SampleHalves& samples,
                           double priors_in_solver_units) {
  ImageCosts costs;
  std::vector<std::vector<float>> pixels;
  for (const int view : views.fitted) {
    const auto v = static_cast<std::size_t>(view);
    const renderer::Film a = source.RenderPrimal(view, samples.a);
    const renderer::Film b = source.RenderPrimal(view, samples.b);
    CheckFinite(a, views.names[v]);
    CheckFinite(b, views.names[v]);
    const RowScales scales =
        MakeRowScales(views, view, loss, CensoredChannels(views.levels[v], AverageFilm(a, b)));
    pixels.push_back(AddSplitHalfCosts(views.levels[v], scales, a, b, costs));
    for (float& share : pixels.back()) {
      share /= static_cast<float>(views.num_channels);
    }
  }
  return {costs.colors / views.num_channels,
          costs.coverage / views.num_channels,
          priors_in_solver_units / views.num_channels,
          std::move(pixels)};
}

bool IsSurelyWorse(const EvaluatedCost& worse, const EvaluatedCost& better) {
  double variance = 0.0;
  for (std::size_t v = 0; v < worse.pixels.size(); ++v) {
    for (std::size_t p = 0; p < worse.pixels[v].size(); ++p) {
      const auto difference =
          static_cast<double>(worse.pixels[v][p]) - static_cast<double>(better.pixels[v][p]);
      variance += difference * difference;
    }
  }
  return worse.Total() - better.Total() > kSure * std::sqrt(variance);
}

ReportedView RenderForReport(const ImageSource& source,
                             const FitViews& views,
                             int view,
                             const SampleHalves& samples,
                             bool estimate_gain) {
  const ViewLevel& level = views.levels[static_cast<std::size_t>(view)];
  const renderer::Film a = source.RenderPrimal(view, samples.a);
  const renderer::Film b = source.RenderPrimal(view, samples.b);
  ReportedView reported;
  reported.film = AverageFilm(a, b);
  if (estimate_gain) {
    reported.gain_factor = EstimateGainFactor(level, a, b);
    for (renderer::Rgba& pixel : reported.film.pixels) {
      pixel.r *= reported.gain_factor;
      pixel.g *= reported.gain_factor;
      pixel.b *= reported.gain_factor;
    }
  }
  reported.quality = MeasureView(level, reported.film, views.silhouettes);
  return reported;
}

const FitViews& FitEvaluation::ViewsAt(double scale) {
  if (!views_ || views_scale_ != scale) {
    views_ = MakeFitViews(observations_, scale);
    views_scale_ = scale;
  }
  return *views_;
}

std::unique_ptr<SceneImageSource> FitEvaluation::MakeSource(const renderer::Scene& scene,
                                                            const renderer::ParameterLayout& layout,
                                                            const FitViews& views) const {
  std::vector<renderer::Camera> cameras;
  for (const ViewLevel& level : views.levels) {
    cameras.push_back(level.camera);
  }
  return std::make_unique<SceneImageSource>(
      scene, layout, std::move(cameras), spec_.estimators, cancel_);
}

SampleHalves FitEvaluation::Samples(int stage, int spp) const {
  return MakeHalves(spec_.seed, stage, 0, SampleUse::kEvaluation, {.spp = spp});
}

ReportImages FitEvaluation::Report(const SampleHalves& samples,
                                   renderer::Scene& scene,
                                   StageReport& report) const {
  const double scale = spec_.stages.back().image_scale;
  std::optional<FitViews> other;
  if (!views_ || views_scale_ != scale) {
    other = MakeFitViews(observations_, scale);
  }
  const FitViews& views = other ? *other : *views_;
  const auto source = MakeSource(scene, {}, views);
  ReportImages images;
  for (std::size_t v = 0; v < views.levels.size(); ++v) {
    const View& view = observations_.views[v];
    ReportedView reported = RenderForReport(
        *source, views, static_cast<int>(v), samples, view.validation && estimate_gains_);
    renderer::Camera& sensor = scene.sensors[v];
    const double limit = std::exp2(exposure_.prior.max_ev);
    sensor.gain = std::clamp(sensor.gain * reported.gain_factor,
                             exposure_.start_gains[v] / limit,
                             exposure_.start_gains[v] * limit);
    report.views.push_back({view.name,
                            view.validation,
                            reported.quality.psnr_linear,
                            reported.quality.psnr_srgb,
                            reported.quality.iou,
                            sensor.gain});
    images.rendered.push_back(std::move(reported.film));
    images.photos.push_back(views.levels[v].photo);
  }
  Average(report);
  return images;
}

}  // namespace pathfit::optim
