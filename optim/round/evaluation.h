#pragma once

#include <vector>

#include "optim/parameter/parameter_set.h"
#include "optim/prior/prior_terms.h"
#include "optim/problem/fit_views.h"
#include "optim/problem/image_source.h"
#include "optim/problem/view_quality.h"

namespace pathfit::optim {

/// Cost of the source's present parameters on one sample set, in reported units: photos,
/// silhouettes and priors.
struct EvaluatedCost {
  double image = 0.0, silhouette = 0.0, priors = 0.0;
  [[nodiscard]] double Total() const { return image + silhouette + priors; }
};
EvaluatedCost EvaluateCost(const ImageSource& source,
                           const FitViews& views,
                           const LossSpec& loss,
                           const SampleHalves& samples,
                           double priors_in_solver_units);

/// One view rendered for a report. Of a held-out view only `gain_factor`, a single number, is
/// estimated from its own photo (1 unless `estimate_gain`); the film has it applied.
struct ReportedView {
  renderer::Film film;
  ViewQuality quality;
  double gain_factor = 1.0;
};
ReportedView RenderForReport(const ImageSource& source,
                             const FitViews& views,
                             int view,
                             const SampleHalves& samples,
                             bool estimate_gain);

}  // namespace pathfit::optim
