#include "app/output/remaining_time.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pathfit::app::remaining_time_test {
namespace {

struct StageRecord {
  std::string name;
  bool many;     ///< unknowns, which move vertices
  double end_s;  ///< when its report was there
  struct Round {
    double wall_s, scale;
    int spp;
    double noise = 0.0;  ///< not known
  };
  std::vector<Round> rounds;
};
constexpr int kMaxRounds = 60;

// configs/axe_demo.yaml, as its records say.
const std::vector<StageRecord> kFit = {
    {"light",
     false,
     9.3,
     {{0.58, 0.25, 8},
      {0.71, 0.25, 12},
      {0.93, 0.25, 18},
      {1.17, 0.25, 28},
      {1.49, 0.25, 40},
      {2.13, 0.25, 60},
      {2.50, 0.25, 64},
      {2.90, 0.25, 64},
      {3.35, 0.25, 64},
      {5.46, 1, 8},
      {7.06, 1, 12},
      {8.61, 1, 16}}},
    {"all",
     true,
     136.6,
     {{9.72, 0.25, 32},   {10.08, 0.25, 32},  {10.40, 0.25, 32},  {10.74, 0.25, 32},
      {11.08, 0.25, 32},  {11.42, 0.25, 32},  {11.85, 0.25, 48},  {12.46, 0.25, 72},
      {13.31, 0.25, 108}, {14.52, 0.25, 162}, {16.58, 0.25, 244}, {18.42, 0.25, 244},
      {20.24, 0.25, 256}, {22.05, 0.25, 256}, {22.67, 0.5, 16},   {23.31, 0.5, 16},
      {24.31, 0.5, 24},   {25.49, 0.5, 36},   {27.16, 0.5, 54},   {29.39, 0.5, 82},
      {32.56, 0.5, 122},  {36.08, 0.5, 128},  {39.59, 0.5, 128},  {43.56, 0.5, 128},
      {45.77, 1, 8},      {47.70, 1, 8},      {49.83, 1, 8},      {52.56, 1, 12},
      {56.06, 1, 18},     {60.76, 1, 28},     {66.10, 1, 40},     {73.52, 1, 60},
      {81.43, 1, 64},     {88.91, 1, 64},     {98.79, 1, 64},     {106.10, 1, 64},
      {113.08, 1, 64},    {120.16, 1, 64},    {127.63, 1, 64}}}};

std::vector<optim::StagePlan> PlansOf(const std::vector<StageRecord>& fit) {
  std::vector<optim::StagePlan> plans;
  for (const StageRecord& record : fit) {
    optim::StageSpec stage;
    stage.name = record.name;
    stage.max_rounds = kMaxRounds;
    stage.coarse_to_fine = record.rounds.front().scale < 1.0;
    plans.push_back(optim::PlanStage(stage, {.moves = record.many, .few = !record.many}, 128, 1e5));
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
  report.max_rounds = kMaxRounds;
  report.wall_s = fit[stage].rounds[round].wall_s;
  report.image_scale = fit[stage].rounds[round].scale;
  report.samples.spp = fit[stage].rounds[round].spp;
  report.noise_relative = fit[stage].rounds[round].noise;
  return report;
}

/// What is said after each round of a stage.
std::vector<double> Forecasts(const std::vector<StageRecord>& fit, std::size_t wanted) {
  RemainingTime time;
  time.Expect(PlansOf(fit));
  optim::StageReport start;
  start.stage = "start";
  start.wall_s = 0.4;
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
    for (std::size_t round = 1; round < said.size() / 2; ++round) {
      const double left = end - kFit[stage].rounds[round].wall_s;
      const double allowed = round == 1 ? 0.3 : 0.4;  // more rounds than usual
      EXPECT_NEAR(said[round], left, allowed * left) << kFit[stage].name << " " << round;
    }
  }
}

// 66 photos of a skull, of 168 pixels: what flat colours and a diffuse surface do not explain is
// far more than noise, and ends levels after 9 and 6 rounds instead of 14 and 14.
const std::vector<StageRecord> kSkull = {{"light",
                                          false,
                                          182.8,
                                          {{24.7, 0.5, 6},
                                           {37.3, 0.5, 8},
                                           {56.4, 0.5, 14},
                                           {74.1, 0.5, 20},
                                           {97.5, 0.5, 30},
                                           {143.2, 0.5, 44},
                                           {151.2, 1, 2},
                                           {158.5, 1, 2}}},
                                         {"all",
                                          true,
                                          802.6,
                                          {{203.3, 0.5, 16, 0.18},
                                           {220.8, 0.5, 16, 0.19},
                                           {238.2, 0.5, 16, 0.18},
                                           {254.9, 0.5, 16, 0.18},
                                           {270.2, 0.5, 16, 0.19},
                                           {285.5, 0.5, 16, 0.19},
                                           {301.6, 0.5, 16, 0.20},
                                           {319.5, 0.5, 16, 0.20},
                                           {358.7, 0.5, 24, 0.11},
                                           {425.5, 1, 8, 0.23},
                                           {486.6, 1, 8, 0.24},
                                           {546.0, 1, 8, 0.24},
                                           {617.3, 1, 12, 0.18},
                                           {672.1, 1, 18, 0.12},
                                           {721.5, 1, 28, 0.09}}}};

TEST(RemainingTime, OfPhotosThatEndLevelsSoonIsToldByTheSecondRound) {
  const std::vector<double> said = Forecasts(kSkull, 1);
  for (const std::size_t round : {1, 2, 10}) {
    const double left = kSkull[1].end_s - kSkull[1].rounds[round].wall_s;
    EXPECT_NEAR(said[round], left, 0.4 * left) << "round " << round;
  }
  EXPECT_GT(said[0], 2.0 * said[1]) << "what is usual";
}

TEST(RemainingTime, OneThatEndsByItselfIsTakenForUsual) {
  std::vector<StageRecord> fit = {{"all", true, 0.0, {}}};
  for (int i = 1; i <= 30; ++i) fit[0].rounds.push_back({0.4 + i, 1.0, 64});
  fit[0].end_s = 31.0;
  const std::vector<double> said = Forecasts(fit, 0);
  EXPECT_NEAR(said[0], 15.0 + 0.4, 0.5) << "sixteen rounds and the end";
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
}  // namespace pathfit::app::remaining_time_test
