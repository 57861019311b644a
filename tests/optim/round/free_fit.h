#pragma once

#include <gtest/gtest.h>

#include "optim/round/fit.h"

namespace pathfit::tests {

/// Fits of a few unknowns, all of them free in every stage.
class FreeFit : public ::testing::Test {
 protected:
  optim::UnknownSpec& Free(renderer::ParameterKind kind, int object) {
    optim::UnknownSpec& unknown = spec_.unknowns.emplace_back();
    unknown.kind = kind;
    unknown.object = object;
    return unknown;
  }

  /// Of the unknowns so far, with up to `max_spp` samples.
  [[nodiscard]] optim::StageSpec Stage(int num_rounds, int spp, int max_spp) const {
    optim::StageSpec stage;
    stage.name = "fit";
    for (std::size_t i = 0; i < spec_.unknowns.size(); ++i) {
      stage.free.push_back(static_cast<int>(i));
    }
    stage.max_rounds = num_rounds;
    stage.samples.spp = spp;
    stage.max_spp = max_spp;
    return stage;
  }

  /// The stage at half the size of the photos, then at the whole.
  [[nodiscard]] static std::vector<optim::StageSpec> CoarseAndFine(const optim::StageSpec& stage) {
    std::vector<optim::StageSpec> stages = {stage, stage};
    stages[0].name = "coarse";
    stages[0].image_scale = 0.5;
    return stages;
  }

  optim::FitSpec spec_;
};

}  // namespace pathfit::tests
