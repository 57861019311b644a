#include "optim/observation/shading.h"

#include <cmath>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/image/color.h"
#include "tests/optim/observation/lit_ball.h"

namespace pathfit::optim::shading_test {
namespace {

using renderer::Image;
using renderer::Vec3;

std::vector<Image> Photos() {
  std::vector<Image> photos;
  for (std::size_t k = 0; k < tests::BallLamps().size(); ++k) {
    photos.push_back(tests::LitBall(tests::BallLamps()[k], tests::kBallStrengths[k], 0.5));
  }
  return photos;
}

TEST(Shading, StrengthsAreFound) {
  const ShadingFit fit = FitShading(Photos(), tests::BallMask(), tests::BallLamps(), {});
  ASSERT_EQ(fit.strengths.size(), 5U);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(fit.strengths[k], tests::kBallStrengths[k], 1e-3);
  EXPECT_NEAR(fit.brightness, 0.5, 2e-3);
  EXPECT_LT(fit.residual, 2e-3);
  EXPECT_TRUE(fit.strengths_told);
  EXPECT_TRUE(fit.has_rim);
  EXPECT_GT(fit.outward.x, 0.9);
  EXPECT_GT(fit.outward.y, 0.9);
}

TEST(Shading, KnownStrengthsStay) {
  const ShadingFit fit =
      FitShading(Photos(), tests::BallMask(), tests::BallLamps(), {1.4, 2.6, 2.0, 2.4, 1.6});
  EXPECT_NEAR(fit.strengths[1], 1.3, 1e-12);
  EXPECT_LT(fit.residual, 1e-6);
  EXPECT_GT(FitShading(Photos(), tests::BallMask(), tests::BallLamps(), {1, 1, 1, 1, 1}).residual,
            0.05);
}

TEST(Shading, TurnedLampsBendTheRimInward) {
  std::vector<Vec3> lamps = tests::BallLamps();
  for (Vec3& lamp : lamps) lamp.y = -lamp.y;
  const ShadingFit fit = FitShading(Photos(), tests::BallMask(), lamps, {});
  EXPECT_GT(fit.outward.x, 0.9);
  EXPECT_LT(fit.outward.y, -0.9);
}

TEST(Shading, EncodedValuesAreExplainedWorse) {
  std::vector<Image> photos = Photos();
  for (Image& photo : photos) {
    for (float& value : photo.data) {
      value = static_cast<float>(renderer::SrgbFromLinear(static_cast<double>(value)));
    }
  }
  EXPECT_GT(FitShading(photos, tests::BallMask(), tests::BallLamps(), {}).residual, 0.02);
}

TEST(Shading, WhatIsFlatDoesNotTellStrengths) {
  const std::vector<Vec3>& lamps = tests::BallLamps();
  Image mask(40, 40, 1);
  mask.data.assign(mask.data.size(), 1.0F);
  std::vector<Image> photos;
  for (std::size_t k = 0; k < lamps.size(); ++k) {
    Image& photo = photos.emplace_back(40, 40, 3);
    for (std::size_t i = 0; i < photo.data.size(); ++i) {
      const double noise = 0.004 * std::sin(12.9898 * static_cast<double>(i + 7919 * k));
      photo.data[i] = static_cast<float>(0.5 * tests::kBallStrengths[k] * lamps[k].z + noise);
    }
  }
  const ShadingFit fit = FitShading(photos, mask, lamps, {});
  EXPECT_FALSE(fit.strengths_told);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(fit.strengths[k], tests::kBallStrengths[k], 0.02);
}

TEST(Shading, RefusesWhatTellsNothing) {
  const std::vector<Image> photos = Photos();
  const std::vector<Vec3> plane = {{0.6, 0, 0.8}, {-0.6, 0, 0.8}, {0, 0, 1}};
  EXPECT_THROW(FitShading({photos[0], photos[1], photos[2]}, tests::BallMask(), plane, {}),
               renderer::SceneError);
  EXPECT_THROW(
      FitShading({photos[0], photos[1], Image(8, 8, 3)}, tests::BallMask(), tests::BallLamps(), {}),
      renderer::SceneError);
  const Image black(tests::kBallSize, tests::kBallSize, 3);
  EXPECT_THROW(FitShading({black, black, black},
                          tests::BallMask(),
                          {tests::BallLamps()[0], tests::BallLamps()[1], tests::BallLamps()[2]},
                          {}),
               renderer::SceneError);
}

}  // namespace
}  // namespace pathfit::optim::shading_test
