#pragma once

#include <map>
#include <string>
#include <vector>

#include "optim/checkpoint/fit_state.h"
#include "optim/problem/image_source.h"
#include "optim/round/round_runner.h"

namespace pathfit::optim {

/// Standard errors by group of unknowns, one per scalar in its unit (FitState::standard_errors).
using RecordedErrors = std::map<std::string, std::vector<double>>;

/// Those of theta, in the unknowns' units. Infinite where an error leaves a number anywhere between
/// its bounds.
void RecordErrors(const ParameterSet& set,
                  const std::vector<double>& theta,
                  const StandardErrors& errors,
                  RecordedErrors& recorded);

/// Of many unknowns in a round: infinite where no pixel depends on them, else NaN.
void RecordUnseen(const ParameterSet& set,
                  const std::vector<double>& diagonal,
                  RecordedErrors& recorded);

/// Of many unknowns at the end of a stage, from one more linearisation at its scene, with the
/// samples of its last round (EstimateErrorsOfMany). Leaves what is recorded where the solver keeps
/// no pairs of all unknowns. `source` must show state.scene. On ranks other than the first it only
/// renders.
void RecordErrorsOfMany(const StageContext& context,
                        ImageSource& source,
                        const FitState& state,
                        RecordedErrors& recorded);

}  // namespace pathfit::optim
