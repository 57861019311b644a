#pragma once

#include <string>
#include <vector>

#include "app/config/experiment_config.h"
#include "app/experiment/experiment.h"
#include "app/experiment/start_check.h"
#include "app/output/fields.h"
#include "optim/round/memory_forecast.h"

namespace pathfit::app {

/// What the page of `pathfit check` draws (ReportPage): `summary` is what --json prints; every
/// photo with the outlines of start and mask, the world's axes and the lights, in pixels of
/// ViewStart; unknowns; the start's 3-D model, unless it would be too large, which a `note` says.
Json CheckJson(const ExperimentConfig& config,
               const Experiment& experiment,
               const StartCheck& start,
               Json summary);

/// Where a light is seen from the middle of the object, for people: "at [0, 2, 0]", "from above",
/// "all around", in the frame it is attached to.
std::string PlaceOfLight(const renderer::Emitter& emitter, const renderer::Scene& scene);

}  // namespace pathfit::app
