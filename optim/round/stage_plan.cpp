#include "optim/round/stage_plan.h"

#include <algorithm>
#include <cmath>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/fit_views.h"
#include "optim/problem/image_problem.h"
#include "optim/round/exposure_gauge.h"
#include "optim/round/round_policy.h"
#include "renderer/core/indices.h"

namespace pathfit::optim {
namespace {

// Usual in recorded fits: of the first level, those between, and the last.
constexpr int kFewRounds = 12;  // a stage that may have no more takes them all
struct UsualRounds {
  int first, middle, last, only;
};
constexpr UsualRounds kOfLights = {6, 2, 3, 5};  // few unknowns that move nothing
constexpr UsualRounds kOfLamps = {5, 2, 5, 5};   // few that move lights only
constexpr UsualRounds kOfPoses = {5, 2, 9, 5};   // few that move what is seen
constexpr UsualRounds kOfShapes = {14, 8, 14, 16};
// Of few that move something, before the last level: steps so far out of their error need no more
// samples.
constexpr int kClearRounds = 4;
constexpr int kRoundsBeforeGrowth = 2;  // of many unknowns
// Rounds of few in the last level, where what is left is all noise; 96 stages take 2 to 6 where it
// is less than .4, 7 to 12 above .7, in one of ten 20 to 52. Fewer, by its square, where nothing
// moves.
constexpr double kLastOfFewByNoise = 12.0;

// Rounds of surfaces by the noise's share of the residual, of the first level, those between and
// the last: six fits of 16 to 66 photos of 96 to 240 pixels take 2 to 15 rounds in the last one for
// shares of .07 to .71, and 3 to 14 in the first for .05 to .33.
constexpr double kFirstByNoise = 40.0, kMiddleByNoise = 24.0, kLastByNoise = 20.0;
constexpr int kFewestRounds = 2;
// Growth of that share from a level to the next, whose photos have more pixels and fewer samples
// for each.
constexpr double kNoiseOfNextLevel = 1.5;

const UsualRounds& UsualOf(StageKind kind) {
  if (!kind.few) return kOfShapes;
  if (!kind.moves) return kOfLights;
  return kind.is_seen ? kOfPoses : kOfLamps;
}

int Usual(const UsualRounds& usual, int level, int num_levels) {
  if (num_levels == 1) return usual.only;
  if (level + 1 == num_levels) return usual.last;
  return level == 0 ? usual.first : usual.middle;
}

/// Rounds of earlier levels, if samples go on growing from there.
int RoundsBefore(const StagePlan& plan, const LevelPlan& level, int LevelPlan::*rounds) {
  int before = 0;
  if (plan.kind.few || plan.kind.moves) return before;
  for (auto earlier = plan.levels.begin(); &*earlier != &level; ++earlier) {
    before += (*earlier).*rounds;
  }
  return before;
}

StageKind KindAlone(const renderer::Scene& scene,
                    const FitSpec& spec,
                    int stage,
                    const ParameterSet& set) {
  return {.moves = set.layout().AnyKind(renderer::MovesGeometry),
          .is_seen = set.layout().AnyKind(renderer::MovesInImages),
          .makes_texture = MakesTexture(scene, spec, stage),
          .few = !Promotes(spec, spec.stages[static_cast<std::size_t>(stage)]) &&
                 ImageProblem::FormsNormalEquations(spec.linear_solver, set.NumScalars())};
}

bool Prepares(const renderer::Scene& scene, const FitSpec& spec, int stage, int smallest_side) {
  const auto index = static_cast<std::size_t>(stage);
  if (index + 1 == spec.stages.size()) return false;
  const StageSpec& next = spec.stages[index + 1];
  const auto is_freed_again = [&](int unknown) {
    return std::ranges::count(next.free, unknown) > 0;
  };
  if (!std::ranges::all_of(spec.stages[index].free, is_freed_again)) return false;
  const ParameterSet set(scene,
                         spec.unknowns,
                         next.free,
                         renderer::AllIndices(scene.sensors.size()),
                         MakeExposureModel(scene, spec.exposure));
  const StageKind kind = KindAlone(scene, spec, stage + 1, set);
  return ScalesOfStage(next, kind, smallest_side).front() < spec.stages[index].image_scale;
}

}  // namespace

bool Promotes(const FitSpec& spec, const StageSpec& stage) {
  return std::ranges::any_of(stage.free, [&](int index) {
    const UnknownSpec& unknown = spec.unknowns[static_cast<std::size_t>(index)];
    return unknown.promotion && !unknown.hold;
  });
}

bool MakesTexture(const renderer::Scene& scene, const FitSpec& spec, int stage) {
  // The first stage that frees a form of the property other than the constant.
  const auto first_of = [&](const Promotion& property) {
    return std::ranges::find_if(spec.stages, [&](const StageSpec& other) {
      return std::ranges::any_of(other.free, [&](int index) {
        return spec.unknowns[static_cast<std::size_t>(index)].promotion == property;
      });
    });
  };
  const auto this_one = spec.stages.begin() + stage;
  return std::ranges::any_of(this_one->free, [&](int index) {
    const UnknownSpec& unknown = spec.unknowns[static_cast<std::size_t>(index)];
    if (!unknown.promotion || unknown.hold ||
        unknown.kind != renderer::ParameterKind::kTextureTexels) {
      return false;
    }
    const auto material = static_cast<std::size_t>(unknown.promotion->material);
    return renderer::TraitsOf(unknown.promotion->property).IsConstant(scene.materials[material]) &&
           first_of(*unknown.promotion) == this_one;
  });
}

StageKind KindOfStage(const renderer::Scene& scene,
                      const FitSpec& spec,
                      int stage,
                      const ParameterSet& set,
                      int smallest_side) {
  StageKind kind = KindAlone(scene, spec, stage, set);
  // Where it changes nothing it is not worth a set of the next one's unknowns.
  const bool has_levels = kind.few && !kind.moves && !kind.makes_texture;
  kind.prepares = has_levels && Prepares(scene, spec, stage, smallest_side);
  return kind;
}

StagePlan PlanStage(const StageSpec& stage, StageKind kind, int smallest_side, double pixels) {
  StagePlan plan{stage, kind, {}};
  const std::vector<double> scales = ScalesOfStage(stage, kind, smallest_side);
  const int num_levels = NumLevels(stage, scales);
  const UsualRounds& usual = UsualOf(kind);
  int most_left = stage.max_rounds;
  int left = stage.max_rounds;
  for (int level = 0; level < static_cast<int>(scales.size()); ++level) {
    const bool is_last = level + 1 == num_levels;
    LevelPlan& one = plan.levels.emplace_back();
    one.scale = scales[static_cast<std::size_t>(level)];
    const double share = one.scale / stage.image_scale;
    one.factor = SampleFactor(stage, one.scale, pixels * share * share, kind);
    one.most_rounds = is_last ? most_left : std::min(most_left, LevelShare(stage, num_levels));
    const int likely =
        stage.max_rounds <= kFewRounds ? one.most_rounds : Usual(usual, level, num_levels);
    one.likely_rounds = std::min({likely, left, is_last ? left : LevelShare(stage, num_levels)});
    most_left -= one.most_rounds;
    left -= one.likely_rounds;
  }
  return plan;
}

std::vector<StagePlan> PlanStages(const renderer::Scene& scene,
                                  const ObservationSet& observations,
                                  const FitSpec& spec) {
  const int side = SmallestSide(observations);
  const ExposureModel exposure = MakeExposureModel(scene, spec.exposure);
  const std::vector<int> all = renderer::AllIndices(scene.sensors.size());
  const double small = std::min(1.0, static_cast<double>(kSmallestSideOfShapes) / side);
  const double pixels = MakeFitViews(observations, small).num_channels / (3.0 * small * small);
  std::vector<StagePlan> plans;
  for (std::size_t i = 0; i < spec.stages.size(); ++i) {
    const StageSpec& stage = spec.stages[i];
    const ParameterSet set(scene, spec.unknowns, stage.free, all, exposure);
    plans.push_back(PlanStage(stage,
                              KindOfStage(scene, spec, static_cast<int>(i), set, side),
                              side,
                              pixels * stage.image_scale * stage.image_scale));
  }
  return plans;
}

int LikelyRounds(const StagePlan& plan, std::size_t level, const LevelNoise& known) {
  const int usual = plan.levels[level].likely_rounds;
  if (plan.levels.size() == 1) return usual;
  const bool is_last = level + 1 == plan.levels.size();
  const double levels_later = std::log2(plan.levels[level].scale / known.scale);
  if (plan.kind.few) {
    const bool tells = is_last && levels_later < 0.5;
    if (!tells || plan.stage.max_rounds <= kFewRounds) return usual;
    const double share = plan.kind.moves ? known.noise : known.noise * known.noise;
    const int rounds = static_cast<int>(std::lround(kLastOfFewByNoise * std::min(1.0, share)));
    return std::min(std::max(kFewestRounds, rounds), plan.levels[level].most_rounds);
  }
  if (!plan.kind.moves) return usual;
  const double noise = known.noise * std::pow(kNoiseOfNextLevel, levels_later);
  const double by_noise = is_last ? kLastByNoise : level == 0 ? kFirstByNoise : kMiddleByNoise;
  const int fewest = std::min(kFewestRounds, usual);
  return static_cast<int>(std::lround(std::clamp(by_noise * noise, 1.0 * fewest, 1.0 * usual)));
}

int RoundsBeforeGrowth(const StagePlan& plan, const LevelPlan& level) {
  if (!plan.kind.few) return kRoundsBeforeGrowth;
  return plan.kind.moves && &level != &plan.levels.back() ? kClearRounds : 0;
}

int LikelySamples(const StagePlan& plan, const LevelPlan& level, int round) {
  const int rounds = round + RoundsBefore(plan, level, &LevelPlan::likely_rounds);
  return SamplesOfRound(
      plan.stage, std::max(0, rounds - RoundsBeforeGrowth(plan, level)), level.factor);
}

int MostSamples(const StagePlan& plan, const LevelPlan& level, int round) {
  return SamplesOfRound(
      plan.stage, round + RoundsBefore(plan, level, &LevelPlan::most_rounds), level.factor);
}

}  // namespace pathfit::optim
