#pragma once

#include <map>
#include <string>
#include <vector>

#include "optim/problem/round_sums.h"
#include "renderer/render_options.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// Whether two scenes with the same list of objects have meshes of the same connectivity, materials
/// that are constant or not alike, and textures and environments of the same size: vectors of
/// unknowns of one then fit the other.
bool SameShapes(const renderer::Scene& a, const renderer::Scene& b);

/// A mean of scenes; empty at weight 0.
struct WeightedScene {
  double weight = 0.0;
  renderer::Scene scene;
};

/// Sample-weighted means over recent rounds: two windows, the older replaced by the newer whenever
/// the number of rounds doubles, so that together they cover the last half to three quarters.
struct AverageState {
  WeightedScene older, newer;
  int newer_start = 1;  ///< round from which the newer window counts
};

/// Whether `round` rounds of some samples per pixel can have these weights.
bool HasWeightsOfRounds(const AverageState& average, int round);

/// Budgets of the boundary terms per interior sample (spp is 1 and stays it) that a stage begins
/// with; its rounds improve them (SplitMeter).
inline constexpr renderer::SampleBudget kStartSplit{
    .spp = 1, .sppe = 0.5, .spp_direct = 0.05, .spp_indirect = 0.05, .spp_pixel = 0.5};

/// Everything a fit needs to continue to the same bits, besides the scene it started from and its
/// specification. Scenes may differ from the start in the values of unknowns, in the shape of
/// meshes (connectivity), textures and environments (size), and in what of materials is constant,
/// per vertex or a texture; the lists of objects are the start's.
struct FitState {
  std::string fingerprint;  ///< of the specification; a state of another one is refused
  int sequence = 0;         ///< counts written states
  int step = 0;             ///< finished rounds of all stages
  int stage = 0;            ///< the current stage; the number of stages when the fit is finished
  int round = 0;            ///< finished rounds of the current stage
  int level = 0;            ///< of the stage's image scales (ScalesOfStage), coarsest first
  int level_start = 0;      ///< rounds of the stage before this level
  int restarts = 0;         ///< of the level, from meshes without needles
  int accepted = 0;         ///< rounds of the stage with a step
  int growths = 0;          ///< of the samples, in the level or, if nothing moves, before it, too
  double wall_s = 0.0;
  [[nodiscard]] int RoundsOfLevel() const { return round - level_start; }

  double radius_factor = 1.0;  ///< on the noise-derived trust radius, shrunk by rejections
  /// Of the step that many unknowns want by the model, what lowers the cost most.
  double step_share = 1.0;
  double damping = 0.0;  ///< kappa of the proximal metric (round/round_policy.h)
  int rejected_in_row = 0;
  renderer::SampleBudget split = kStartSplit;  ///< for the next round, per interior sample
  std::vector<double> costs;                   ///< of the level's rounds, at their start
  /// Of held-out photos at the start of the level's last rounds, in solver units; empty where they
  /// do not stand out of the renderings' noise.
  std::vector<double> held_out_costs;
  /// After the level's last step, by the samples that it was made from: lower than it is, by what
  /// the step fitted of their noise.
  double promised_cost = 0.0;
  RoundSums rounds;      ///< of the level, where normal equations are formed; else empty
  int within_error = 0;  ///< rounds in a row whose step its own error explains, by the model
  int still = 0;         ///< rounds in a row whose step moved nothing by more than kStillPixels
  /// Signs that steps hardly lower the cost (kSignsOfRound) since one surely did; with few
  /// unknowns, a cost that is not noise.
  int flat = 0;
  /// By which beliefs about what photos leave open are weighed: UnexplainedResidual of the last
  /// round, as far as it has changed.
  double unexplained = 0.0;
  bool precise = false;  ///< whether more samples would hardly improve the result, by the model
  /// By group of unknowns (name), one per scalar in its unit; of the last stage that fitted it.
  /// Infinite where no photo tells it, NaN where only that is not so (without a model).
  std::map<std::string, std::vector<double>> standard_errors;

  renderer::Scene scene;  ///< after the last finished round
  renderer::Scene stage_start;
  renderer::Scene level_scene;  ///< that the level began with: what units of priors are taken from
  AverageState average;
};

}  // namespace pathfit::optim
