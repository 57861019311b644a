#include "optim/round/evaluation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "optim/problem/pixel_rows.h"
#include "optim/ranks/film_stream.h"
#include "optim/round/exposure_gauge.h"
#include "optim/round/round_policy.h"
#include "renderer/core/indices.h"

namespace pathfit::optim {
namespace {

constexpr double kSure = 3.0;  // standard errors

void Average(StageReport& report) {
  struct Means {
    KnownMean psnr_srgb, psnr_linear, iou;
  } fit, val;
  for (const ViewReport& view : report.views) {
    Means& means = view.validation ? val : fit;
    means.psnr_srgb.Add(view.psnr_srgb);
    means.psnr_linear.Add(view.psnr_linear);
    means.iou.Add(view.iou);
  }
  report.psnr_srgb_fit = fit.psnr_srgb.Value();
  report.psnr_srgb_val = val.psnr_srgb.Value();
  report.psnr_linear_fit = fit.psnr_linear.Value();
  report.psnr_linear_val = val.psnr_linear.Value();
  report.iou_fit = fit.iou.Value();
  report.iou_val = val.iou.Value();
}

/// Of one view or several.
struct ViewComparison {
  std::vector<ImageCosts> costs;            ///< by scene
  std::vector<double> squared_differences;  ///< each with each, in reported units

  explicit ViewComparison(std::size_t num_scenes = 0)
      : costs(num_scenes), squared_differences(num_scenes * num_scenes) {}
  static void VisitParts(auto& view, const auto& visit) {
    visit(view.costs);
    visit(view.squared_differences);
  }
  void Add(const ViewComparison& other) {
    for (std::size_t i = 0; i < costs.size(); ++i) {
      costs[i].Add(other.costs[i]);
    }
    for (std::size_t i = 0; i < squared_differences.size(); ++i) {
      squared_differences[i] += other.squared_differences[i];
    }
  }
};

ViewComparison CompareView(const std::vector<ComparedScene>& scenes,
                           const FitViews& views,
                           int view,
                           const LossSpec& loss,
                           const SampleHalves& samples) {
  const std::size_t n = scenes.size();
  ViewComparison comparison(n);
  const auto v = static_cast<std::size_t>(view);
  const ViewLevel level = views.levels[v].Unpack();
  std::vector<std::vector<float>> pixels;
  for (std::size_t i = 0; i < n; ++i) {
    const renderer::Film a = scenes[i].source->RenderPrimal(view, samples.a);
    const renderer::Film b = scenes[i].source->RenderPrimal(view, samples.b);
    CheckFinite(a, views.names[v]);
    CheckFinite(b, views.names[v]);
    const RowScales scales =
        MakeRowScales(level, views.silhouettes, loss, JudgePixels(level, loss, a, b));
    pixels.push_back(AddSplitHalfCosts(level, scales, a, b, comparison.costs[i]));
    for (float& share : pixels.back()) {
      share /= static_cast<float>(views.num_channels);
    }
    for (std::size_t j = 0; j < i; ++j) {
      double& sum = comparison.squared_differences[i * n + j];
      for (std::size_t p = 0; p < pixels[i].size(); ++p) {
        const auto difference =
            static_cast<double>(pixels[i][p]) - static_cast<double>(pixels[j][p]);
        sum += difference * difference;
      }
      comparison.squared_differences[j * n + i] = sum;
    }
  }
  return comparison;
}

}  // namespace

template <>
struct Parts<ReportedView> {
  static void Visit(auto& view, const auto& visit) {
    visit(view.film);
    visit(view.quality);
    visit(view.costs);
    visit(view.gain_factors);
  }
};

bool CostComparison::IsSurelyWorse(std::size_t i, std::size_t j) const {
  const double variance = squared_differences[i * costs.size() + j];
  return costs[i].Total() - costs[j].Total() > kSure * std::sqrt(variance);
}

CostComparison CompareCosts(const std::vector<ComparedScene>& scenes,
                            const FitViews& views,
                            const LossSpec& loss,
                            const SampleHalves& samples,
                            Division& division) {
  const std::size_t n = scenes.size();
  ViewComparison sums(n);
  division.ForEachThing<ViewComparison>(
      Division::Kind::kComparison,
      views.fitted,
      [&](std::size_t i, const auto& give) {
        give(CompareView(scenes, views, views.fitted[i], loss, samples));
      },
      [&](std::size_t, const ViewComparison& view) { sums.Add(view); });
  CostComparison comparison;
  comparison.squared_differences = division.Share(sums.squared_differences);
  for (std::size_t i = 0; i < n; ++i) {
    comparison.costs.push_back({sums.costs[i].colors / views.num_channels,
                                sums.costs[i].coverage / views.num_channels,
                                scenes[i].priors_in_solver_units / views.num_channels});
  }
  comparison.costs = division.Share(comparison.costs);
  return comparison;
}

ReportedView RenderForReport(const ImageSource& source,
                             const FitViews& views,
                             int view,
                             const ViewLevel& level,
                             const LossSpec& loss,
                             const SampleHalves& samples,
                             FreeGains free) {
  renderer::Film a = source.RenderPrimal(view, samples.a);
  renderer::Film b = source.RenderPrimal(view, samples.b);
  ReportedView reported;
  if (free != FreeGains::kNone) {
    reported.gain_factors = EstimateGainFactors(level, a, b, free);
    for (renderer::Film* half : {&a, &b}) {
      for (renderer::Rgba& pixel : half->pixels) {
        pixel = renderer::Rgba(pixel.Color() * reported.gain_factors, pixel.a);
      }
    }
  }
  reported.film = AverageFilm(a, b);
  reported.quality = MeasureView(level, a, b, views.silhouettes);
  const RowScales scales =
      MakeRowScales(level, views.silhouettes, loss, JudgePixels(level, loss, a, b));
  AddSplitHalfCosts(level, scales, a, b, reported.costs);
  return reported;
}

const FitViews& FitEvaluation::ViewsAt(double scale) {
  if (!views_ || views_scale_ != scale) {
    views_ = MakeFitViews(observations_, scale);
    views_scale_ = scale;
  }
  return *views_;
}

const FitViews& FitEvaluation::SharedViewsAt(double scale) {
  const double num_channels =
      division_.Share(division_.IsFirst() ? ViewsAt(scale).num_channels : 0.0);
  if (!division_.IsFirst() && (!views_ || views_scale_ != scale)) {
    views_ = MakeFitViews(observations_, scale, num_channels);
    views_scale_ = scale;
  }
  return *views_;
}

std::unique_ptr<SceneImageSource> FitEvaluation::MakeSource(const renderer::Scene& scene,
                                                            const renderer::ParameterLayout& layout,
                                                            const FitViews& views) const {
  std::vector<renderer::Camera> cameras;
  for (const PackedLevel& level : views.levels) {
    cameras.push_back(level.camera());
  }
  return std::make_unique<SceneImageSource>(
      scene, layout, std::move(cameras), spec_.estimators, cancel_);
}

SampleHalves FitEvaluation::Samples(int stage, int spp) const {
  return MakeHalves(spec_.seed, stage, 0, SampleUse::kEvaluation, {.spp = spp});
}

ImageCosts FitEvaluation::Report(const SampleHalves& samples,
                                 FitObserver& observer,
                                 renderer::Scene& scene,
                                 StageReport& report) const {
  const double scale = spec_.stages.back().image_scale;
  std::optional<FitViews> other;
  if (!views_ || views_scale_ != scale) {
    other = MakeFitViews(observations_, scale, 1.0);  // no cost is reported by it
  }
  const FitViews& views = other ? *other : *views_;
  const auto source = MakeSource(scene, {}, views);
  ImageCosts fitted;
  division_.ForEachThing<ReportedView>(
      Division::Kind::kReport,
      renderer::AllIndices(views.levels.size()),
      [&](std::size_t v, const auto& give) {
        give(RenderForReport(*source,
                             views,
                             static_cast<int>(v),
                             views.levels[v].Unpack(),
                             spec_.loss,
                             samples,
                             observations_.views[v].validation ? free_gains_ : FreeGains::kNone));
      },
      [&](std::size_t v, const ReportedView& reported) {
        const View& view = observations_.views[v];
        if (!view.validation) {
          fitted.Add(reported.costs);
        }
        renderer::Camera& sensor = scene.sensors[v];
        const double limit = std::exp2(exposure_.prior.max_ev);
        const renderer::Rgb& factors = reported.gain_factors;
        sensor.gain = std::clamp(sensor.gain * factors.g,
                                 exposure_.start_gains[v] / limit,
                                 exposure_.start_gains[v] * limit);
        sensor.red = std::clamp(sensor.red * (factors.r / factors.g), 1.0 / limit, limit);
        sensor.blue = std::clamp(sensor.blue * (factors.b / factors.g), 1.0 / limit, limit);
        report.views.push_back({view.name,
                                view.validation,
                                reported.quality.psnr_linear,
                                reported.quality.psnr_srgb,
                                reported.quality.iou,
                                sensor.gain});
        observer.OnView(report.stage, v, reported.film, views.levels[v].Unpack());
      });
  Average(report);
  return fitted;
}

}  // namespace pathfit::optim
