#include "optim/round/seed_policy.h"

#include <set>

#include <gtest/gtest.h>

#include "optim/round/iterate_average.h"

namespace pathfit {
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

TEST(SeedPolicy, GrowsSamplesToTheMaximum) {
  optim::StageSpec stage;
  stage.samples.spp = 4;
  stage.max_spp = 16;
  stage.spp_growth = 1.5;
  EXPECT_EQ(optim::SamplesOfRound(stage, 1), 4);
  EXPECT_EQ(optim::SamplesOfRound(stage, 2), 6);
  EXPECT_EQ(optim::SamplesOfRound(stage, 100), 16);
  stage.samples.spp = 1;
  EXPECT_EQ(optim::SamplesOfRound(stage, 1), 2);
}

TEST(IterateAverage, WeighsTheLaterRoundsBySamples) {
  optim::AverageState average;
  // Rounds 1..8: windows start at 4 and 8 in the end.
  for (int round = 1; round <= 8; ++round) {
    optim::AddIterate(average, round, round, {static_cast<double>(round)});
  }
  const double expected = (4.0 * 4 + 5 * 5 + 6 * 6 + 7 * 7 + 8 * 8) / (4.0 + 5 + 6 + 7 + 8);
  EXPECT_DOUBLE_EQ(optim::AverageIterate(average)[0], expected);
  EXPECT_TRUE(optim::AverageIterate({}).empty());
}

}  // namespace
}  // namespace pathfit
