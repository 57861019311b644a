#pragma once

#include <cstdint>
#include <string>

#include "optim/checkpoint/fit_state.h"
#include "optim/observation/observation.h"
#include "optim/parameter/parameter_set.h"
#include "optim/problem/image_source.h"
#include "optim/problem/split_half_cost.h"
#include "optim/round/fit_report.h"
#include "optim/round/fit_spec.h"
#include "optim/solver/trust_region_solver.h"

namespace pathfit::optim {

/// Why samples are drawn; each use of a round has its own stream.
enum class SampleUse { kFit, kValidation, kEvaluation };

/// What decides how a stage goes.
struct StageKind {
  bool moves = false;          ///< something changes place
  bool is_seen = false;        ///< what does is in the photos itself, not only its shadow
  bool makes_texture = false;  ///< MakesTexture (stage_plan.h)
  bool few = false;            ///< its unknowns: normal equations are formed
  bool prepares = false;  ///< they move nothing, and the next stage frees all of them again and
                          ///< begins with smaller photos than this one's last
};

/// Scales of the photos that a stage goes through, the last one image_scale. One that moves
/// something begins where the photos still show where things are, and doubles: a step then reaches
/// as far as a thing may be off, and large errors do not end in wrong valleys. So does one that
/// makes a texture: what its large places are is told by many samples of few texels.
/// `smallest_side`: of the photos, in pixels. Few unknowns can begin where there are few pixels; if
/// they move nothing, one small size brings them near at little cost, and is all if the stage only
/// prepares the next one: what it finds more exactly would be that of a scene which still changes.
/// Fewer levels if there are hardly rounds for them.
std::vector<double> ScalesOfStage(const StageSpec& stage, StageKind kind, int smallest_side);
/// Levels of a stage that goes through these scales: one more, the next stage's, if they end before
/// image_scale.
int NumLevels(const StageSpec& stage, const std::vector<double>& scales);

/// Of all photos, in pixels.
int SmallestSide(const ObservationSet& observations);

/// Rounds after which a level that is not the last one ends.
int LevelShare(const StageSpec& stage, int num_levels);

/// Factor of a stage's budgets at one of its scales, where `pixels` of all fitted photos are
/// evidence. With few unknowns their error depends on the samples of all pixels together, which
/// stay the same where something moves: its small photos must find the way. Elsewhere they only
/// bring it near. Many pixels need few samples each, unless the stage says how many. With many
/// unknowns, the error of each pixel counts, too.
double SampleFactor(const StageSpec& stage, double scale, double pixels, StageKind kind);

/// Samples per pixel of both halves together in a round, after its level's samples have grown so
/// many times: factor * spp * growth^growths, even, at most factor * max_spp.
int SamplesOfRound(const StageSpec& stage, int growths, double factor);

/// Whether what the level's last step fitted of its samples' noise is too large a share of what it
/// gained: `cost` is that of the point it led to, by samples of their own. Not before the first.
bool FitsNoise(const FitState& state, double cost);

/// Budgets of a round with `spp` samples: what the stage gives, grown like spp, else those of
/// `split` (SplitMeter); 0 for terms that do not exist.
renderer::SampleBudget BudgetOfRound(const StageBudget& stage,
                                     int spp,
                                     const renderer::SampleBudget& split,
                                     const renderer::EstimatorOptions& estimators);
/// The split that a round's budgets are of; that of `split` where there are none.
renderer::SampleBudget SplitOfRound(const renderer::SampleBudget& round,
                                    const renderer::SampleBudget& split);
inline constexpr int kValidationSpp = 32;         ///< at most, of held-out photos in a round
inline constexpr std::size_t kMeasuredViews = 4;  ///< of a round, for its split

/// Two halves with seeds of (seed, stage, round, use, half); the budgets of `both` are of both
/// together, at least 1 interior sample each.
SampleHalves MakeHalves(
    std::uint64_t seed, int stage, int round, SampleUse use, const renderer::SampleBudget& both);

/// Relative noise of the residual: rms of the half difference over rms of the mean, 0..1 or so.
double RelativeNoise(const ImageCosts& costs);

/// Trust radius of a round: 1 / noise^2, times the factor that rejections leave behind. The noise
/// is that of the mean of both halves. Measured on synthetic fits of shape, colours and light: 1 /
/// (16 noise^2) leaves 4 to 6 times the shape error after the same rounds, 6 / noise^2 spoils badly
/// determined texels.
double TrustRadius(double relative_noise, double radius_factor);

/// Weight mu of the proximal metric: kappa times the mean diagonal of J^T J over the moving
/// coordinates, raised with the noise like the solver's own damping.
double ProximalWeight(double kappa, double mean_diagonal, double relative_noise);

inline constexpr double kStartDamping = 1e-3;  ///< kappa in a stage's first round
/// Radius factor of a level's first round where radii are kept: what the photos determine badly
/// moves little until the steps have shown that their model holds.
inline constexpr double kStartRadiusFactor = 1e-3;

/// Adapts radius_factor, step_share, kappa and the count of rejections to how the round went: a
/// step that did what the model said loosens both, a poor one or a rejection tightens them.
/// `keeps_radius`: the next round begins from the radius that this one ended with.
void AdaptStepControl(const SolveOutcome& outcome, bool keeps_radius, FitState& state);

/// Why the stage's level (of num_levels) ends after the rounds in `state`; empty = it goes on.
/// Depends on the state only, so a resumed fit decides alike. Costs are compared as means of
/// kStopWindow rounds, since each has noise of its own. Where those of fitted photos still fall but
/// held-out ones show no gain, many unknowns fit what is in the photos and not in the scene.
std::string StopReason(const StageSpec& stage, const FitState& state, int num_levels);

/// Of photos at a stage's first level, in pixels. Measured: a bunny 25 degrees off is found from 8
/// pixels, from 16 hardly.
inline constexpr int kSmallestSide = 8;
inline constexpr int kSmallestSideOfShapes = 32;
inline constexpr int kRoundsWithinError = 2;
/// So many steps of few unknowns in a row that their error explains end a stage, precise or not: as
/// many again would lower what the renderings' noise adds to the errors by less than a third.
inline constexpr int kRoundsOfChance = 12;
/// A round whose cost no longer falls counts so many signs; one if the renderings' noise is most of
/// the residual, none if the cost does not stand out of that noise.
inline constexpr int kSignsOfRound = 3;
inline constexpr int kSignsOfEnd = 2 * kSignsOfRound;
inline constexpr double kStillPixels = 0.1;

inline constexpr int kStopWindow = 3;
/// So many rounds of many unknowns, each of which wanted more samples than it may have, end a
/// stage: they cost most and gain least.
inline constexpr int kRoundsShortOfSamples = 7;
inline constexpr int kMaxRejectedRounds = 4;

/// Whether the mean cost of the last kStopWindow rounds is not below that of the ones before by
/// more than the share `least`; not while there are too few.
bool NoLongerFalls(const std::vector<double>& costs, double least);
/// So, or whether the last cost is not below the one before by a round's part of `least`, where
/// single costs, which are `over_noise` standard deviations each, tell as much.
bool NoLongerFalls(const std::vector<double>& costs, double least, double over_noise);

/// Adds the scene after round `round` (from 1) with the round's samples as weight, as a mean of the
/// unknowns of `set`; all else is that of `scene`. A scene of other shapes (SameShapes) begins a
/// new mean.
void AddIterate(AverageState& average,
                int round,
                double weight,
                const ParameterSet& set,
                const renderer::Scene& scene);

/// The mean over the last half to three quarters of the rounds; weight 0 before the first.
WeightedScene AverageIterate(const AverageState& average, const ParameterSet& set);

}  // namespace pathfit::optim
