#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/output/fit_history.h"
#include "optim/round/fit_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::app {

/// One per scalar of a group of unknowns: infinite where the photos do not determine it, NaN where
/// only that is not so.
using StandardErrorsByName = std::map<std::string, std::vector<double>>;

/// One row per scalar of small unknowns (three components at most) and one per large group, in the
/// order of the specification. The gains of all photos are one group. Throws SceneError for an
/// unknown that `result` does not have.
std::vector<ParameterSummary> SummarizeParameters(const optim::FitSpec& spec,
                                                  const renderer::Scene& start,
                                                  const renderer::Scene& result,
                                                  const StandardErrorsByName& errors = {});

/// Standard errors of the sensors' gains, NaN where they are not known.
std::vector<double> GainErrors(const renderer::Scene& scene, const StandardErrorsByName& errors);

/// Of each block of one object's unknowns of a kind the root of its components' summed squares,
/// infinite and NaN as those; empty unless any of `num_blocks` is known.
std::vector<double> BlockErrors(const renderer::Scene& scene,
                                renderer::ParameterKind kind,
                                int object,
                                std::size_t num_blocks,
                                const StandardErrorsByName& errors);

}  // namespace pathfit::app
