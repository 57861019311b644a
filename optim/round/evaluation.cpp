#include "optim/round/evaluation.h"

#include <cstddef>

#include "optim/problem/pixel_rows.h"
#include "optim/problem/split_half_cost.h"
#include "optim/round/exposure_gauge.h"

namespace pathfit::optim {

EvaluatedCost EvaluateCost(const ImageSource& source,
                           const FitViews& views,
                           const LossSpec& loss,
                           const SampleHalves& samples,
                           double priors_in_solver_units) {
  ImageCosts costs;
  for (const int view : views.fitted) {
    const auto v = static_cast<std::size_t>(view);
    const renderer::Film a = source.RenderPrimal(view, samples.a);
    const renderer::Film b = source.RenderPrimal(view, samples.b);
    CheckFinite(a, views.names[v]);
    CheckFinite(b, views.names[v]);
    const RowScales scales = MakeRowScales(views, view, loss, AverageFilm(a, b));
    AddSplitHalfCosts(views.levels[v], scales, a, b, {}, costs);
  }
  return {costs.colors / views.num_channels,
          costs.coverage / views.num_channels,
          priors_in_solver_units / views.num_channels};
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

}  // namespace pathfit::optim
