#pragma once

#include <string>

#include "optim/checkpoint/fit_state.h"
#include "optim/round/fit_spec.h"

namespace pathfit::optim {

/// Why a stage ends after the rounds in `state`; empty = it goes on. Depends on the state only, so
/// a resumed fit decides alike. Costs are compared as means of kStopWindow rounds, since each has
/// noise of its own.
std::string StopReason(const StageSpec& stage, const FitState& state);

inline constexpr int kStopWindow = 3;
inline constexpr int kMaxRejectedRounds = 4;

}  // namespace pathfit::optim
