#pragma once

#include <string>

#include "optim/checkpoint/fit_state.h"
#include "optim/observation/observation.h"
#include "optim/parameter/parameter_set.h"
#include "optim/round/fit_spec.h"

namespace pathfit::optim {

/// What a state depends on, in words: seed, views, stages with their free unknowns and scales,
/// unknowns with their sizes at the start. Rounds, samples and limits may change between sessions,
/// as may weights: such a resumed fit is valid, if not the same.
std::string FitFingerprint(const FitSpec& spec,
                           const ParameterSet& all_unknowns,
                           const ObservationSet& observations);

/// Throws renderer::IoError unless a fit of this fingerprint can have written `state`: another
/// experiment's, or counters and numbers out of their ranges.
void ValidateState(const FitState& state, const FitSpec& spec, const std::string& fingerprint);

}  // namespace pathfit::optim
