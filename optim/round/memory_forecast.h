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
};

/// By stage: linearises a few of the views at the scene, with the samples of the stage's first
/// round, and concludes from them. Throws what that throws, and MemoryError if it is more than the
/// limit. Some view must be fitted.
std::vector<StageMemory> ForecastStages(const renderer::Scene& scene,
                                        const ObservationSet& observations,
                                        const FitSpec& spec);

}  // namespace pathfit::optim
