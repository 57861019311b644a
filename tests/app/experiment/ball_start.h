#pragma once

#include <gtest/gtest.h>

#include "app/experiment/experiment.h"
#include "tests/optim/round/synthetic_fit.h"

namespace pathfit::app {

/// A ball, right as it starts, and five photos of it, the last one held out.
class BallStart : public ::testing::Test {
 protected:
  BallStart() {
    experiment_.scene = tests::BallScene(2, 5, 40);
    experiment_.observations = tests::Photograph(experiment_.scene, 16);
    config_.source.file = "ball.yaml";
    config_.input.emplace();
  }

  ExperimentConfig config_;
  Experiment experiment_;
};

}  // namespace pathfit::app
