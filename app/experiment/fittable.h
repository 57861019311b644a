#pragma once

#include <string>

#include "app/config/experiment_config.h"

namespace pathfit::app {

/// Throws ConfigError where photos, unknowns or stages are missing, or the stage of this name
/// (empty: any).
void RequireFittable(const ExperimentConfig& config, const std::string& stop_after);

}  // namespace pathfit::app
