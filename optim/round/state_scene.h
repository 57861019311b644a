#pragma once

#include "optim/checkpoint/fit_state.h"
#include "optim/round/fit_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// `start` with the current values of a checkpoint of a fit that began there. Throws IoError if the
/// state is of another specification.
renderer::Scene SceneOfState(renderer::Scene start, const FitSpec& spec, const FitState& state);

}  // namespace pathfit::optim
