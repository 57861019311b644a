#pragma once

#include <string>
#include <vector>

#include "optim/observation/observation.h"
#include "optim/problem/problem_size.h"
#include "optim/round/fit_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

struct StageTimes {
  double first_round_s = 0.0;
  /// Of the rounds that it usually takes (PlanStage), and of all that it may have; with its end and
  /// its pictures, of the first stage also those of the start.
  double likely_s = 0.0, most_s = 0.0;
};

/// What a stage of a fit will take, at its last scale.
struct StageMemory {
  LinearSolverKind solver = LinearSolverKind::kGram;
  double num_scalars = 0.0;           ///< of the meshes that the stage will have
  double num_scalars_at_start = 0.0;  ///< of those that the fit begins with
  double jacobian_bytes = 0.0;        ///< of what is kept of all photos' derivatives
  std::vector<MemoryItem> items;      ///< at their peak; the first is this process as it is
  StageTimes times;
  double likely_half_size_s = 0.0;  ///< likely_s if photos were half as wide and high
};

enum class ForecastParts { kMemory, kMemoryAndTimes };

/// This process as it is.
MemoryItem LoadedMemory();

/// Of one stage: linearises a few of the views at the scene, with the samples of the stage's first
/// round, and concludes from them; large photos are reduced for that. Times are of this machine as
/// busy as it is now. Throws what linearising throws, and MemoryError if that alone is more than
/// the limit. Some view must be fitted.
StageMemory ForecastStage(const renderer::Scene& scene,
                          const ObservationSet& observations,
                          const FitSpec& spec,
                          int stage,
                          const MemoryItem& loaded,
                          ForecastParts parts);

/// Throws MemoryError with a table if a stage takes more than `max_bytes` (0 = no limit).
void RequireMemory(const StageMemory& memory, const std::string& stage, double max_bytes);

/// All stages, each within the limit of `spec` (RequireMemory).
std::vector<StageMemory> ForecastStages(const renderer::Scene& scene,
                                        const ObservationSet& observations,
                                        const FitSpec& spec,
                                        ForecastParts parts = ForecastParts::kMemoryAndTimes);

}  // namespace pathfit::optim
