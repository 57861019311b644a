#pragma once

#include <string>
#include <vector>

#include "app/output/fit_history.h"
#include "optim/round/fit_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::app {

/// One row per scalar of small unknowns (three components at most) and one per large group, in the
/// order of the specification. The gains of all photos are one group. Throws SceneError for an
/// unknown that `result` does not have.
std::vector<ParameterSummary> SummarizeParameters(const optim::FitSpec& spec,
                                                  const renderer::Scene& start,
                                                  const renderer::Scene& result);

}  // namespace pathfit::app
