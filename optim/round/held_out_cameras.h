#pragma once

#include "optim/round/evaluation.h"
#include "optim/round/round_runner.h"

namespace pathfit::optim {

/// Whether a stage frees where the cameras of all photos are.
bool FreesCameras(const FitSpec& spec, const StageSpec& stage);

/// After a round, one step of these cameras, and of the exposures that are free with them, each by
/// its own photo alone. Nothing else learns of those photos, which so tell of the scene, and not of
/// cameras that stayed behind while the others and the scene moved. On the first rank, which has
/// all photos.
void MoveHeldOutCameras(const StageContext& context,
                        const FitEvaluation& evaluation,
                        const RoundReport& round,
                        FitState& state);

}  // namespace pathfit::optim
