#pragma once

#include <string>
#include <vector>

#include "optim/observation/observation.h"
#include "optim/problem/problem_size.h"
#include "optim/round/fit_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// What a stage of a fit will take, at its last scale.
struct StageMemory {
  LinearSolverKind solver = LinearSolverKind::kGram;
  double num_scalars = 0.0;       ///< of the meshes that the stage will have
  double jacobian_bytes = 0.0;    ///< of what is kept of all photos' derivatives
  std::vector<MemoryItem> items;  ///< at their peak; the first is this process as it is
  double first_round_s = 0.0;
  /// Of all rounds that the stage may have, its end and its pictures; of the first one also those
  /// of the start. It ends sooner where nothing more is to be gained, which only the fit can tell.
  double most_s = 0.0;
};

/// By stage: linearises a few of the views at the scene, with the samples of the stage's first
/// round, and concludes from them. Times are of this machine as busy as it is now. Throws what that
/// throws, and MemoryError if it is more than the limit. Some view must be fitted.
std::vector<StageMemory> ForecastStages(const renderer::Scene& scene,
                                        const ObservationSet& observations,
                                        const FitSpec& spec);

}  // namespace pathfit::optim
