#include "optim/round/stopping_rule.h"

#include <gtest/gtest.h>

namespace pathfit {
namespace {

TEST(StoppingRule, EndsAtTheLimitOrWhenNothingIsAccepted) {
  optim::StageSpec stage;
  stage.max_rounds = 10;
  optim::FitState state;
  state.round = 9;
  EXPECT_EQ(optim::StopReason(stage, state), "");
  state.round = 10;
  EXPECT_EQ(optim::StopReason(stage, state), "max_rounds");
  state.round = 5;
  state.rejected_in_row = optim::kMaxRejectedRounds;
  EXPECT_NE(optim::StopReason(stage, state), "");
}

TEST(StoppingRule, ComparesMeansOfRounds) {
  optim::StageSpec stage;
  stage.max_rounds = 100;
  stage.stop_relative_cost = 0.01;
  optim::FitState state;
  state.round = 6;
  state.costs = {1.2, 0.8, 1.0, 0.9, 0.7, 0.8};
  EXPECT_EQ(optim::StopReason(stage, state), "");
  state.costs = {1.2, 0.8, 1.0, 0.8, 1.2, 0.995};
  EXPECT_NE(optim::StopReason(stage, state), "");
  stage.stop_relative_cost = 0.0;
  EXPECT_EQ(optim::StopReason(stage, state), "");
}

}  // namespace
}  // namespace pathfit
