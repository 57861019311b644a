#include "optim/round/exposure_gauge.h"

#include <cmath>

#include <gtest/gtest.h>

#include "renderer/renderer.h"
#include "tests/support/test_scenes.h"

namespace pathfit::exposure_gauge_test {
namespace {

using optim::UnknownSpec;
using renderer::ParameterKind;

class ExposureGaugeTest : public testing::Test {
 protected:
  ExposureGaugeTest() {
    scene_.sensors.push_back(scene_.sensors[0]);
    scene_.sensors[0].gain = 2.0;
    scene_.sensors[1].gain = 1.5;
    unknowns_[0].kind = ParameterKind::kExposure;
    unknowns_[0].object = -1;
    for (int e = 0; e < 3; ++e) {
      unknowns_[static_cast<std::size_t>(e) + 1].kind = ParameterKind::kLightIntensity;
      unknowns_[static_cast<std::size_t>(e) + 1].object = e;
    }
  }

  renderer::Scene scene_ = tests::BallAndWall();
  std::vector<UnknownSpec> unknowns_{4};
  optim::ExposureModel exposure_{{1.0, 1.0}, 0.3, 3.0};
};

TEST_F(ExposureGaugeTest, MovesTheMeanIntoTheLightsAndKeepsTheImage) {
  const optim::ParameterSet set(scene_, unknowns_, {0, 1, 2, 3}, {0, 1}, exposure_);
  renderer::Scene fixed = scene_;
  FixExposureGauge(set, {0, 1}, exposure_, fixed);
  EXPECT_NEAR(fixed.sensors[0].gain * fixed.sensors[1].gain, 1.0, 1e-12);
  EXPECT_NEAR(fixed.sensors[0].gain / fixed.sensors[1].gain, 2.0 / 1.5, 1e-12);
  const auto before = renderer::Renderer(scene_).RenderPrimal(scene_.sensors[0], {});
  const auto after = renderer::Renderer(fixed).RenderPrimal(fixed.sensors[0], {});
  for (std::size_t p = 0; p < before.pixels.size(); ++p) {
    EXPECT_NEAR(before.pixels[p].g, after.pixels[p].g, 1e-9 * (1.0 + before.pixels[p].g));
  }
}

TEST_F(ExposureGaugeTest, LeavesEverythingIfALightIsKnown) {
  const optim::ParameterSet set(scene_, unknowns_, {0, 1, 2}, {0, 1}, exposure_);
  renderer::Scene same = scene_;
  FixExposureGauge(set, {0, 1}, exposure_, same);
  EXPECT_EQ(same.sensors[0].gain, 2.0);
}

TEST_F(ExposureGaugeTest, EstimatesOneFactorOfAHeldOutView) {
  optim::ViewLevel level;
  level.photo = renderer::Image(2, 1, 3);
  level.photo.data = {0.3F, 0.6F, 0.9F, 9.0F, 9.0F, 9.0F};
  level.color_weight = renderer::Image(2, 1, 1);
  level.color_weight.data = {1.0F, 0.0F};
  renderer::Film film(2, 1);
  film.pixels[0] = {0.2, 0.4, 0.6, 1.0};
  film.pixels[1] = {5.0, 1.0, 1.0, 1.0};
  EXPECT_NEAR(EstimateGainFactors(level, film, film, optim::FreeGains::kOne).b, 1.5, 1e-6);
  film.pixels[0].r = 0.1;
  const renderer::Rgb each = EstimateGainFactors(level, film, film, optim::FreeGains::kPerChannel);
  EXPECT_NEAR(each.r, 3.0, 1e-6);
  EXPECT_NEAR(each.g, 1.5, 1e-6);
  EXPECT_EQ(EstimateGainFactors(level, film, film, optim::FreeGains::kNone).r, 1.0);
}

TEST_F(ExposureGaugeTest, MovesMeanWhiteBalancesToo) {
  scene_.sensors[0].red = 1.3;
  scene_.sensors[1].blue = 0.8;
  unknowns_.emplace_back();
  unknowns_.back().kind = ParameterKind::kWhiteBalance;
  unknowns_.back().object = -1;
  const optim::ParameterSet set(scene_, unknowns_, {0, 1, 2, 3, 4}, {0, 1}, exposure_);
  renderer::Scene fixed = scene_;
  FixExposureGauge(set, {0, 1}, exposure_, fixed);
  EXPECT_NEAR(fixed.sensors[0].red * fixed.sensors[1].red, 1.0, 1e-12);
  EXPECT_NEAR(fixed.sensors[0].blue / fixed.sensors[1].blue, 1.0 / 0.8, 1e-12);
  // Lights of another colour are sampled otherwise: their products with the gains are the image.
  const std::vector<double> before = set.layout().Gather(scene_),
                            after = set.layout().Gather(fixed);
  int num_compared = 0;
  for (const renderer::ParameterGroup& group : set.layout().groups()) {
    if (group.kind != ParameterKind::kLightIntensity) continue;
    for (std::size_t v = 0; v < 2; ++v) {
      for (int c = 0; c < 3; ++c) {
        const std::size_t i = static_cast<std::size_t>(group.first_scalar + c);
        EXPECT_NEAR(before[i] * scene_.sensors[v].ChannelGains()[c],
                    after[i] * fixed.sensors[v].ChannelGains()[c],
                    1e-9 * before[i]);
        ++num_compared;
      }
    }
  }
  EXPECT_EQ(num_compared, 18);
}

}  // namespace
}  // namespace pathfit::exposure_gauge_test
