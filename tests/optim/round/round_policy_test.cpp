#include "optim/round/round_policy.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/test_scenes.h"

namespace pathfit::round_policy_test {
namespace {

using optim::MakeHalves;
using optim::SampleUse;

TEST(SeedPolicy, GivesEveryHalfOfEveryUseItsOwnSeed) {
  std::set<std::uint64_t> seeds;
  int count = 0;
  for (const std::uint64_t seed : {0U, 1U}) {
    for (int stage = 0; stage < 3; ++stage) {
      for (int round = 0; round < 20; ++round) {
        for (const auto use : {SampleUse::kFit, SampleUse::kValidation, SampleUse::kEvaluation}) {
          const optim::SampleHalves halves = MakeHalves(seed, stage, round, use, {8, 4.0});
          seeds.insert(halves.a.seed);
          seeds.insert(halves.b.seed);
          count += 2;
          EXPECT_EQ(halves.a.spp + halves.b.spp, 8);
          EXPECT_EQ(halves.a.sppe + halves.b.sppe, 4.0);
        }
      }
    }
  }
  EXPECT_EQ(seeds.size(), static_cast<std::size_t>(count));
}

/// Runs are repeated with the same bits by later versions, too.
TEST(SeedPolicy, SeedsStayWhatTheyWere) {
  const auto seed = [](SampleUse use) { return MakeHalves(9, 2, 5, use, {8, 4.0}).b.seed; };
  EXPECT_EQ(seed(SampleUse::kFit), 678113099755951U);
  EXPECT_EQ(seed(SampleUse::kValidation), 261337934091994U);
  EXPECT_EQ(seed(SampleUse::kEvaluation), 5350337694364695U);
}

TEST(SeedPolicy, GrowsSamplesToTheMaximum) {
  optim::StageSpec stage;
  stage.samples.spp = 4;
  stage.max_spp = 16;
  stage.spp_growth = 1.5;
  EXPECT_EQ(optim::SamplesOfRound(stage, 0, 1.0), 4);
  EXPECT_EQ(optim::SamplesOfRound(stage, 1, 1.0), 6);
  EXPECT_EQ(optim::SamplesOfRound(stage, 100, 1.0), 16);
  stage.samples.spp = 1;
  EXPECT_EQ(optim::SamplesOfRound(stage, 0, 1.0), 2);
}

TEST(SeedPolicy, TellsStepsThatGainLessThanTheyFitOfTheNoise) {
  optim::FitState state;
  EXPECT_FALSE(optim::FitsNoise(state, 1.0)) << "no step yet";
  state.costs = {1.0};
  state.promised_cost = 0.5;
  EXPECT_FALSE(optim::FitsNoise(state, 0.5)) << "all that was promised";
  EXPECT_FALSE(optim::FitsNoise(state, 0.55)) << "fell by .45, with .025 of noise fitted";
  EXPECT_TRUE(optim::FitsNoise(state, 0.9)) << "fell by .1, with .2 of noise fitted";
  EXPECT_TRUE(optim::FitsNoise(state, 1.1));
}

class IterateAverageTest : public testing::Test {
 protected:
  static optim::UnknownSpec Roughness() {
    optim::UnknownSpec unknown;
    unknown.kind = renderer::ParameterKind::kRoughness;
    unknown.object = 1;
    return unknown;
  }
  renderer::Scene SceneOf(double roughness) {
    renderer::Scene scene = scene_;
    set_.layout().Scatter({roughness}, scene);
    return scene;
  }
  double MeanOf(const optim::AverageState& average) {
    return set_.layout().Gather(optim::AverageIterate(average, set_).scene)[0];
  }

  renderer::Scene scene_ = tests::BallAndWall();
  optim::ParameterSet set_{scene_, {Roughness()}, {0}, {}, {}};
};

TEST_F(IterateAverageTest, WeighsTheLaterRoundsBySamples) {
  optim::AverageState average;
  // Rounds 1..8: windows start at 4 and 8 in the end.
  for (int round = 1; round <= 8; ++round) {
    optim::AddIterate(average, round, round, set_, SceneOf(0.1 * round));
  }
  const double expected = 0.1 * (4.0 * 4 + 5 * 5 + 6 * 6 + 7 * 7 + 8 * 8) / (4.0 + 5 + 6 + 7 + 8);
  EXPECT_NEAR(MeanOf(average), expected, 1e-15);
  EXPECT_EQ(optim::AverageIterate({}, set_).weight, 0.0);
}

TEST_F(IterateAverageTest, BeginsAnewWhenAMeshChangesItsConnectivity) {
  optim::AverageState average;
  for (int round = 1; round <= 5; ++round) {
    optim::AddIterate(average, round, 1.0, set_, SceneOf(0.1));
  }
  scene_.meshes[0].mesh = renderer::MakeIcosphere(3, 1.0);
  optim::AddIterate(average, 6, 1.0, set_, SceneOf(0.4));
  EXPECT_EQ(MeanOf(average), 0.4);
  optim::AddIterate(average, 7, 1.0, set_, SceneOf(0.6));
  EXPECT_NEAR(MeanOf(average), 0.5, 1e-15);
  EXPECT_EQ(average.newer.scene.meshes[0].mesh.triangles, scene_.meshes[0].mesh.triangles);
}

TEST(StoppingRule, EndsAtTheLimitOrWhenNothingIsAccepted) {
  optim::StageSpec stage;
  stage.max_rounds = 10;
  optim::FitState state;
  state.round = 9;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "");
  state.round = 10;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "max_rounds");
  state.round = 5;
  state.rejected_in_row = optim::kMaxRejectedRounds;
  EXPECT_NE(optim::StopReason(stage, state, 1), "");
}

TEST(StoppingRule, FewUnknownsEndByTheErrorOfTheirSteps) {
  optim::StageSpec stage;
  optim::FitState state;
  state.round = 12;
  state.rounds.model.weight = 1.0;
  state.costs = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0};  // says nothing: noise
  EXPECT_EQ(optim::StopReason(stage, state, 1), "");
  state.within_error = optim::kRoundsWithinError;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "") << "more samples would help";
  state.precise = true;
  EXPECT_NE(optim::StopReason(stage, state, 1).find("converged"), std::string::npos);
}

TEST(StoppingRule, FewUnknownsEndAfterManyStepsOfChanceThoughTheirErrorsAreNotSmall) {
  optim::StageSpec stage;
  optim::FitState state;
  state.round = 20;
  state.rounds.model.weight = 1.0;
  state.within_error = optim::kRoundsOfChance - 1;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "");
  state.within_error = optim::kRoundsOfChance;
  EXPECT_NE(optim::StopReason(stage, state, 1).find("falls slowly"), std::string::npos);
  EXPECT_EQ(optim::StopReason(stage, state, 2), "") << "the next level sees more";
  stage.stop_relative_cost = 0.0;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "") << "as many as the config says";
}

TEST(StoppingRule, ManyUnknownsEndWhereHeldOutPhotosGainNoMore) {
  optim::StageSpec stage;
  optim::FitState state;
  state.round = 6;
  state.costs = {6.0, 5.0, 4.0, 3.0, 2.0, 1.0};
  EXPECT_EQ(optim::StopReason(stage, state, 1), "")
      << "no held-out photos, or all of them is noise";
  state.held_out_costs = {6.0, 5.0, 4.0, 3.9, 3.8, 3.7};
  EXPECT_EQ(optim::StopReason(stage, state, 1), "");
  state.held_out_costs = {3.9, 3.8, 3.7, 3.7, 3.8, 3.9};
  EXPECT_NE(optim::StopReason(stage, state, 1), "");
  stage.stop_relative_cost = 0.0;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "") << "never";
}

TEST(StoppingRule, ManyUnknownsEndSomeRoundsAfterTheirSamplesCouldNotGrow) {
  optim::StageSpec stage;
  stage.samples.spp = 8;
  stage.spp_growth = 1.5;
  stage.max_spp = 64;  // after six growths
  optim::FitState state;
  state.round = 13;
  for (int i = 0; i < state.round; ++i) state.costs.push_back(std::pow(0.95, i));
  state.growths = 12;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "");
  state.growths = 13;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "max_spp samples gain little more");
  EXPECT_EQ(optim::StopReason(stage, state, 2), "") << "the next level begins with few again";
  state.level_start = 2;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "") << "rounds of earlier levels do not count";
  state.level_start = 0;
  state.rounds.model.weight = 1.0;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "") << "few unknowns end by their errors";
  state.rounds.model.weight = 0.0;
  for (const auto change : {+[](optim::StageSpec& s) { s.samples.spp = 64; },
                            +[](optim::StageSpec& s) { s.spp_growth = 1.0; },
                            +[](optim::StageSpec& s) { s.stop_relative_cost = 0.0; }}) {
    optim::StageSpec other = stage;
    change(other);
    EXPECT_EQ(optim::StopReason(other, state, 1), "") << "as many as the config says";
  }
}

TEST(StoppingRule, CoarseLevelsEndWhenNothingMovesOrTheirShareIsUsed) {
  optim::StageSpec stage;
  stage.max_rounds = 40;
  optim::FitState state;
  state.round = 5;
  state.precise = true;
  state.within_error = optim::kRoundsWithinError;
  EXPECT_EQ(optim::StopReason(stage, state, 3), "") << "steps within their error may be large";
  state.still = optim::kRoundsWithinError;
  EXPECT_NE(optim::StopReason(stage, state, 3), "");
  state.still = 0;
  state.round = 11;
  EXPECT_NE(optim::StopReason(stage, state, 3), "") << "a quarter of 40, and one";
  state.level = 2;
  state.level_start = 10;
  state.within_error = 0;
  EXPECT_EQ(optim::StopReason(stage, state, 3), "");
}

TEST(StoppingRule, CoarseLevelsEndWhereTheNextGainsMore) {
  optim::StageSpec stage;
  stage.max_rounds = 60;
  optim::FitState state;
  state.round = 6;
  for (int i = 0; i < 6; ++i) state.costs.push_back(std::pow(0.98, i));
  EXPECT_EQ(optim::StopReason(stage, state, 3), "cost no longer falls") << "6 % in three rounds";
  state.level = 2;
  EXPECT_EQ(optim::StopReason(stage, state, 3), "") << "there is no next one";
  state.level = 0;
  for (int i = 0; i < 6; ++i) state.costs[static_cast<std::size_t>(i)] = std::pow(0.95, i);
  EXPECT_EQ(optim::StopReason(stage, state, 3), "") << "14 % in three rounds";
  stage.stop_relative_cost = 0.0;
  state.costs.assign(6, 1.0);
  EXPECT_EQ(optim::StopReason(stage, state, 3), "") << "was not wanted";
}

TEST(ScalesOfStage, WhatMovesOrMakesATextureBeginsWithSmallPhotos) {
  optim::StageSpec stage;
  stage.image_scale = 0.5;
  const std::vector<double> last{0.5};
  EXPECT_EQ(optim::ScalesOfStage(stage, {}, 512), last);
  EXPECT_EQ(optim::ScalesOfStage(stage, {.few = true}, 512), (std::vector<double>{0.0625, 0.5}))
      << "what stands still need not be followed through all sizes";
  EXPECT_EQ(optim::NumLevels(stage, {0.0625, 0.5}), 2);
  EXPECT_EQ(optim::ScalesOfStage(stage, {.few = true, .prepares = true}, 512),
            std::vector<double>{0.0625});
  EXPECT_EQ(optim::NumLevels(stage, {0.0625}), 2) << "the next stage's is the last one";
  EXPECT_EQ(optim::ScalesOfStage(stage, {.prepares = true}, 512), last) << "it has one size";
  EXPECT_EQ(optim::ScalesOfStage(stage, {.moves = true, .few = true}, 128),
            (std::vector<double>{0.0625, 0.125, 0.25, 0.5}));
  EXPECT_EQ(optim::ScalesOfStage(stage, {.moves = true}, 128), (std::vector<double>{0.25, 0.5}));
  EXPECT_EQ(optim::ScalesOfStage(stage, {.moves = true, .few = true}, 10), last);
  stage.max_rounds = 4;
  EXPECT_EQ(optim::ScalesOfStage(stage, {.moves = true, .few = true}, 128),
            (std::vector<double>{0.25, 0.5}));
  stage.coarse_to_fine = false;
  EXPECT_EQ(optim::ScalesOfStage(stage, {.moves = true, .few = true}, 128), last);
  // As many samples in all, as few unknowns need; more per pixel for many.
  EXPECT_EQ(optim::SampleFactor(stage, 0.125, 1e3, {.moves = true, .few = true}), 16.0);
  EXPECT_EQ(optim::SampleFactor(stage, 0.125, 1e3, {.moves = true}), 4.0);
  EXPECT_EQ(optim::SampleFactor(stage, 0.125, 1e3, {.few = true}), 1.0);
  // Where there are very many pixels few of each are enough, unless their number was given.
  EXPECT_EQ(optim::SampleFactor(stage, 0.5, 1e5, {.few = true}), 0.5);
  EXPECT_EQ(optim::SampleFactor(stage, 0.125, 2e4, {.moves = true, .few = true}), 2.5);
  EXPECT_EQ(optim::SampleFactor(stage, 0.125, 1e9, {.moves = true}), 4.0);
  stage.samples.spp = 8;
  EXPECT_EQ(optim::SampleFactor(stage, 0.5, 1e5, {.few = true}), 1.0);
}

TEST(StoppingRule, SingleCostsTellWhereTheirNoiseIsSmall) {
  const double least = 0.01;
  EXPECT_TRUE(optim::NoLongerFalls({1.1, 1.0, 0.998}, least, 1e3));
  EXPECT_FALSE(optim::NoLongerFalls({1.1, 1.0, 0.998}, least, 1e2)) << "may be noise";
  EXPECT_FALSE(optim::NoLongerFalls({1.1, 1.0, 0.996}, least, 1e3)) << "1.2 % in three rounds";
  EXPECT_FALSE(optim::NoLongerFalls({1.0}, least, 1e3));
  EXPECT_TRUE(optim::NoLongerFalls({1.1, 0.9, 1.0, 1.1, 0.9, 0.995}, least, 1.0)) << "their means";
}

TEST(StoppingRule, RoundsWhoseCostIsMostlyNoiseAreLesserSigns) {
  optim::StageSpec stage;
  stage.max_rounds = 40;
  optim::FitState state;
  state.round = 7;
  state.flat = optim::kSignsOfRound;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "");
  state.flat = optim::kSignsOfRound + 1;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "") << "one that is clear, and one that is not";
  state.flat = 2 * optim::kSignsOfRound;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "cost no longer falls");
}

TEST(StoppingRule, ComparesMeansOfRounds) {
  optim::StageSpec stage;
  stage.max_rounds = 100;
  stage.stop_relative_cost = 0.01;
  optim::FitState state;
  state.round = 6;
  state.costs = {1.2, 0.8, 1.0, 0.9, 0.7, 0.8};
  EXPECT_EQ(optim::StopReason(stage, state, 1), "");
  state.costs = {1.2, 0.8, 1.0, 0.8, 1.2, 0.995};
  EXPECT_NE(optim::StopReason(stage, state, 1), "");
  stage.stop_relative_cost = 0.0;
  EXPECT_EQ(optim::StopReason(stage, state, 1), "");
}

TEST(BudgetOfRound, GivenOnesHoldAndOthersFollowTheSplit) {
  optim::StageBudget stage;
  stage.spp = 8;
  stage.spp_direct = 2.0;
  renderer::EstimatorOptions estimators;
  estimators.max_bounces = 1;
  const renderer::SampleBudget split{
      .spp = 1, .sppe = 0.25, .spp_direct = 9.0, .spp_indirect = 0.5, .spp_pixel = 0.125};
  renderer::SampleBudget round = optim::BudgetOfRound(stage, 16, split, estimators);
  EXPECT_EQ(round.spp, 16);
  EXPECT_EQ(round.sppe, 4.0);
  EXPECT_EQ(round.spp_direct, 4.0);    // grows as spp does
  EXPECT_EQ(round.spp_indirect, 0.0);  // one bounce has none
  EXPECT_EQ(round.spp_pixel, 0.0);     // nor has the image form
  const renderer::SampleBudget used = optim::SplitOfRound(round, split);
  EXPECT_EQ(used.spp, 1);
  EXPECT_EQ(used.sppe, 0.25);
  EXPECT_EQ(used.spp_direct, 0.25);
  EXPECT_EQ(used.spp_indirect, 0.5);
  estimators.max_bounces = 2;
  estimators.form = renderer::DerivativeForm::kMaterial;
  round = optim::BudgetOfRound(stage, 16, split, estimators);
  EXPECT_EQ(round.spp_indirect, 8.0);
  EXPECT_EQ(round.spp_pixel, 2.0);
}

}  // namespace
}  // namespace pathfit::round_policy_test
