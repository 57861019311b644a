#include "optim/round/stage_plan.h"

#include <gtest/gtest.h>

namespace pathfit::optim::stage_plan_test {
namespace {

constexpr int kSide = 128;
constexpr double kPixels = 1e5;

int LikelyRounds(const StagePlan& plan) {
  int rounds = 0;
  for (const LevelPlan& level : plan.levels) rounds += level.likely_rounds;
  return rounds;
}

TEST(StagePlan, LightsThatMoveTakeFewerRoundsThanWhatPhotosShow) {
  StageSpec stage;
  const StagePlan lamps = PlanStage(stage, {.moves = true, .few = true}, kSide, kPixels);
  const StagePlan poses =
      PlanStage(stage, {.moves = true, .is_seen = true, .few = true}, kSide, kPixels);
  ASSERT_EQ(lamps.levels.size(), poses.levels.size());
  EXPECT_LT(LikelyRounds(lamps), LikelyRounds(poses));
  EXPECT_EQ(lamps.levels.back().scale, 1.0);
}

TEST(StagePlan, NoiseTellsHowLongFewUnknownsTakeInTheLastLevel) {
  for (const bool moves : {false, true}) {
    const StagePlan plan =
        PlanStage({}, {.moves = moves, .is_seen = true, .few = true}, kSide, kPixels);
    const std::size_t last = plan.levels.size() - 1;
    ASSERT_GT(last, 0U);
    const auto rounds = [&](double noise) {
      return LikelyRounds(plan, last, {noise, plan.levels[last].scale});
    };
    EXPECT_EQ(rounds(0.05), 2);
    EXPECT_EQ(rounds(0.5), moves ? 6 : 3);
    EXPECT_EQ(rounds(1.0), 12);
    EXPECT_EQ(rounds(5.0), 12);
    // Of what is still to come, nothing is known.
    const LevelNoise first{0.05, plan.levels[0].scale};
    EXPECT_EQ(LikelyRounds(plan, last, first), plan.levels[last].likely_rounds);
    EXPECT_EQ(LikelyRounds(plan, 0, first), plan.levels[0].likely_rounds);
  }
}

TEST(StagePlan, OneWithFewRoundsIsTakenToNeedThemAll) {
  StageSpec stage;
  stage.max_rounds = 7;
  for (const bool moves : {false, true}) {
    const StagePlan plan = PlanStage(stage, {.moves = moves, .few = true}, kSide, kPixels);
    EXPECT_EQ(LikelyRounds(plan), stage.max_rounds);
    for (const LevelPlan& level : plan.levels) EXPECT_LE(level.likely_rounds, level.most_rounds);
  }
}

}  // namespace
}  // namespace pathfit::optim::stage_plan_test
