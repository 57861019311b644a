#include "app/output/remaining_time.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pathfit::app {
namespace {

struct StageRecord {
  std::string name;
  int max_rounds;
  double image_scale, end_s;  ///< when its report was there
  struct Round {
    double wall_s, scale;
    int spp;
  };
  std::vector<Round> rounds;
};

// A fit of 24 photos, three stages that ended with their last round, as its records say.
const std::vector<StageRecord> kFit = {
    {"light",
     4,
     0.25,
     8.9,
     {{2.46, 0.125, 16}, {3.37, 0.125, 24}, {5.24, 0.25, 16}, {7.47, 0.25, 24}}},
    {"shape",
     8,
     0.5,
     62.5,
     {{11.76, 0.5, 8},
      {15.06, 0.5, 12},
      {18.38, 0.5, 12},
      {22.76, 0.5, 18},
      {28.94, 0.5, 28},
      {37.23, 0.5, 40},
      {48.49, 0.5, 60},
      {60.60, 0.5, 64}}},
    {"colours",
     4,
     0.5,
     78.0,
     {{64.23, 0.5, 8}, {66.41, 0.5, 12}, {69.31, 0.5, 18}, {73.13, 0.5, 28}}}};

std::vector<optim::StagePlan> PlansOf(const std::vector<StageRecord>& fit) {
  std::vector<optim::StagePlan> plans;
  for (const StageRecord& record : fit) {
    optim::StageSpec stage;
    stage.name = record.name;
    stage.max_rounds = record.max_rounds;
    stage.image_scale = record.image_scale;
    stage.coarse_to_fine = record.rounds.front().scale < record.image_scale;
    stage.samples.spp = record.rounds.front().spp;
    plans.push_back(optim::PlanStage(stage, !stage.coarse_to_fine, stage.coarse_to_fine, 256, 1e4));
  }
  return plans;
}

optim::RoundReport RoundOf(const std::vector<StageRecord>& fit,
                           std::size_t stage,
                           std::size_t round) {
  optim::RoundReport report;
  report.stage = fit[stage].name;
  report.stage_index = static_cast<int>(stage);
  report.num_stages = static_cast<int>(fit.size());
  report.round = static_cast<int>(round) + 1;
  report.max_rounds = fit[stage].max_rounds;
  report.wall_s = fit[stage].rounds[round].wall_s;
  report.image_scale = fit[stage].rounds[round].scale;
  report.samples.spp = fit[stage].rounds[round].spp;
  return report;
}

/// What is said after each round of a stage.
std::vector<double> Forecasts(const std::vector<StageRecord>& fit, std::size_t wanted) {
  RemainingTime time;
  time.Expect(PlansOf(fit));
  optim::StageReport start;
  start.stage = "start";
  start.wall_s = 1.5;
  time.OnStage(start);
  std::vector<double> said;
  for (std::size_t s = 0; s < fit.size(); ++s) {
    for (std::size_t r = 0; r < fit[s].rounds.size(); ++r) {
      time.OnRound(RoundOf(fit, s, r));
      if (s == wanted) said.push_back(time.Seconds());
    }
    optim::StageReport end;
    end.stage = fit[s].name;
    end.wall_s = fit[s].end_s;
    time.OnStage(end);
  }
  return said;
}

TEST(RemainingTime, IsThatOfTheWholeFitAfterTheSecondRound) {
  const double end = kFit.back().end_s;
  for (std::size_t stage = 0; stage < kFit.size(); ++stage) {
    const std::vector<double> said = Forecasts(kFit, stage);
    const double left = end - kFit[stage].rounds[1].wall_s;
    // The first stage knows nothing of what a round with vertices takes.
    const double allowed = stage == 0 ? 0.6 : stage == 1 ? 0.3 : 0.5;
    EXPECT_NEAR(said[1], left, allowed * left) << kFit[stage].name;
  }
  // The nearer the end, the better.
  const std::vector<double> said = Forecasts(kFit, 1);
  EXPECT_NEAR(said.back(), end - 60.6, 0.3 * (end - 60.6));
}

TEST(RemainingTime, OneThatEndsByItselfIsTakenForUsual) {
  std::vector<StageRecord> fit = {{"all", 60, 1.0, 0.0, {}}};
  for (int i = 1; i <= 30; ++i) fit[0].rounds.push_back({1.5 + i, 1.0, 64});
  fit[0].end_s = 32.0;
  const std::vector<double> said = Forecasts(fit, 0);
  EXPECT_NEAR(said[0], 15.0 + 1.5, 0.5) << "sixteen rounds and the end";
  EXPECT_GT(said[1], said[3]);
  EXPECT_GT(said.back(), 0.0) << "not yet over";
  for (const double seconds : said) EXPECT_LT(seconds, 17.0);
}

TEST(RemainingTime, KnowsNothingWithoutRoundsAndOfRoundsWithoutStages) {
  RemainingTime time;
  EXPECT_EQ(time.Seconds(), 0.0);
  optim::RoundReport report = RoundOf(kFit, 1, 0);
  report.render_s = 1.0;
  report.jacobian_s = 2.0;
  time.OnRound(report);  // the first of a run that was resumed
  EXPECT_GT(time.Seconds(), 3.0);
  report.wall_s = std::nan("");
  report.round = report.max_rounds;
  time.OnRound(report);
  EXPECT_EQ(time.Seconds(), 0.0);
}

}  // namespace
}  // namespace pathfit::app
