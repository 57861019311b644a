#include "optim/solver/step_bounds.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/test_scenes.h"

namespace pathfit::step_bounds_test {
namespace {

using optim::UnknownSpec;
using renderer::ParameterKind;

TEST(BoundsOfStep, ByTheScaleOnWhichThePhotosAreLinear) {
  std::vector<UnknownSpec> unknowns(4);
  unknowns[0].kind = ParameterKind::kRoughness;
  unknowns[0].object = 1;
  unknowns[0].lower = 0.03;
  unknowns[0].upper = 1.0;
  unknowns[1].kind = ParameterKind::kMetallic;
  unknowns[1].object = 1;
  unknowns[1].lower = 0.0;
  unknowns[1].upper = 1.0;
  unknowns[2].kind = ParameterKind::kLightIntensity;
  unknowns[2].object = 1;
  unknowns[2].parameterization = optim::Parameterization::kLog;
  unknowns[2].upper = 1e3;
  unknowns[3].kind = ParameterKind::kVertexPositions;
  renderer::Scene scene = tests::BallAndWall();
  scene.materials[1].bsdf = renderer::MetallicRoughnessBsdf{0.3, 0.4};
  const optim::ParameterSet set(scene, unknowns, {0, 1, 2, 3}, {0}, {});
  const auto of = [&](ParameterKind kind, double theta, int object = 1) {
    const auto scalar =
        static_cast<std::size_t>(set.BlockOffset(set.layout().FirstBlock(kind, object)));
    std::vector<double> at(set.NumScalars(), theta);
    return BoundsOfStep(set, at, scalar);
  };
  EXPECT_EQ(of(ParameterKind::kRoughness, 0.3), std::pair(0.15, 0.6)) << "twofold";
  EXPECT_EQ(of(ParameterKind::kRoughness, 0.7).second, 1.0);
  EXPECT_EQ(of(ParameterKind::kMetallic, 0.4), std::pair(0.0, 1.0));
  EXPECT_NEAR(of(ParameterKind::kLightIntensity, 1.0).second, 1.0 + std::log(4.0), 1e-3);
  EXPECT_TRUE(std::isinf(of(ParameterKind::kVertexPositions, 0.1, 0).second));
}

}  // namespace
}  // namespace pathfit::step_bounds_test
