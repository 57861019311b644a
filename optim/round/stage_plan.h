#pragma once

#include <cstddef>
#include <vector>

#include "optim/observation/observation.h"
#include "optim/parameter/parameter_set.h"
#include "optim/round/fit_spec.h"
#include "optim/round/round_policy.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// What a stage does at one of the sizes of its photos.
struct LevelPlan {
  double scale = 1.0;
  double factor = 1.0;  ///< of its samples (SampleFactor)
  int likely_rounds = 0;
  int most_rounds = 0;
};

/// How a stage goes: when it ends by itself cannot be known before, but how many rounds that
/// usually takes. One with a small max_rounds is taken to need all of them.
struct StagePlan {
  StageSpec stage;
  StageKind kind;
  std::vector<LevelPlan> levels;
};

/// Whether a stage frees values of vertices or texels that may still have to be made: many.
bool Promotes(const FitSpec& spec, const StageSpec& stage);
/// Whether stage number `stage` makes a texture as fine as its photos of what is one constant in
/// `scene`, with which it or the fit begins.
bool MakesTexture(const renderer::Scene& scene, const FitSpec& spec, int stage);

/// Of a stage that begins with `scene` (or whose fit does), where it frees `set`. `smallest_side`:
/// of the photos.
StageKind KindOfStage(const renderer::Scene& scene,
                      const FitSpec& spec,
                      int stage,
                      const ParameterSet& set,
                      int smallest_side);

/// `pixels`: of all fitted photos that are evidence, at the stage's last scale. `smallest_side`: of
/// the photos.
StagePlan PlanStage(const StageSpec& stage, StageKind kind, int smallest_side, double pixels);

/// Of all stages, concluded from the scene they begin with.
std::vector<StagePlan> PlanStages(const renderer::Scene& scene,
                                  const ObservationSet& observations,
                                  const FitSpec& spec);

/// The renderings' share of the residual (RelativeNoise) in the second round of the level of this
/// scale.
struct LevelNoise {
  double noise = 0.0;
  double scale = 1.0;
};
/// Rounds of the plan's level number `level` that are likely where a level's noise is known: of
/// surfaces no more than are usual, and few where what is left is not noise, since then the photos
/// end levels. Of few unknowns the last level's own noise tells.
int LikelyRounds(const StagePlan& plan, std::size_t level, const LevelNoise& known);
/// Growth of the share at a stage's start, with usual samples and its last photos, to that in the
/// last level's second round.
inline constexpr double kNoiseAfterStart = 3.3;

/// After a level's first round, how many of the levels in `plan` usually take no more samples.
int RoundsBeforeGrowth(const StagePlan& plan, const LevelPlan& level);
/// Of a round (from 0) of one of the levels in `plan`, as samples usually grow.
int LikelySamples(const StagePlan& plan, const LevelPlan& level, int round);
/// As above if they grow with each of the most rounds.
int MostSamples(const StagePlan& plan, const LevelPlan& level, int round);

}  // namespace pathfit::optim
