#include "optim/parameter/parameter_set.h"

#include <cmath>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/support/test_scenes.h"

namespace pathfit::parameter_set_test {
namespace {

using optim::ParameterSet;
using optim::UnknownSpec;
using renderer::ParameterKind;

std::vector<UnknownSpec> Unknowns() {
  std::vector<UnknownSpec> unknowns(4);
  unknowns[0].kind = ParameterKind::kExposure;
  unknowns[0].object = -1;
  unknowns[1].kind = ParameterKind::kLightIntensity;
  unknowns[1].object = 1;
  unknowns[1].parameterization = optim::Parameterization::kLog;
  unknowns[1].upper = 3.5;
  unknowns[2].kind = ParameterKind::kVertexPositions;
  unknowns[3].kind = ParameterKind::kRoughness;
  unknowns[3].object = 1;
  unknowns[3].hold = true;
  return unknowns;
}

TEST(ParameterSet, PutsVerticesFirstAndLeavesHeldUnknownsOut) {
  const renderer::Scene scene = tests::BallAndWall();
  const ParameterSet set(scene, Unknowns(), {0, 1, 2, 3}, {0}, {{1.0}, 0.3, 3.0});
  ASSERT_EQ(set.layout().groups().size(), 3U);
  EXPECT_EQ(set.layout().groups()[0].kind, ParameterKind::kVertexPositions);
  EXPECT_EQ(set.UnknownOfGroup(0), 2);
  EXPECT_EQ(set.layout().groups()[2].kind, ParameterKind::kExposure);
  EXPECT_EQ(set.NumScalars(), static_cast<std::size_t>(set.layout().NumScalars()));
  EXPECT_EQ(set.BlockSize(set.layout().groups()[2].first_block), 1);
  for (std::int32_t b = 0; b < set.layout().NumBlocks(); ++b) {
    EXPECT_EQ(set.BlockOffset(b), static_cast<std::size_t>(set.layout().FirstScalarOfBlock(b)));
  }
}

TEST(ParameterSet, OneLensIsFreedByAnyOfItsPhotosAndMovesAll) {
  renderer::Scene scene = tests::BallAndWall();
  scene.sensors.resize(5, scene.sensors[0]);
  std::vector<UnknownSpec> unknowns(2);
  unknowns[0].kind = ParameterKind::kFocal;
  unknowns[1].kind = ParameterKind::kCameraPosition;
  for (UnknownSpec& unknown : unknowns) unknown.object = -1;
  unknowns[0].sharing = {0, 1, 0, 1, 4};
  // Photo 0 is held out, and so is 4, which has a lens of its own.
  const ParameterSet set(scene, unknowns, {0, 1}, {1, 2, 3}, {});
  const auto& groups = set.layout().groups();
  ASSERT_EQ(groups.size(), 5U);
  EXPECT_EQ(groups[0].kind, ParameterKind::kCameraPosition);
  EXPECT_EQ(set.layout().FirstBlock(ParameterKind::kCameraPosition, 0), -1);
  EXPECT_EQ(set.layout().FirstBlock(ParameterKind::kFocal, 0),
            set.layout().FirstBlock(ParameterKind::kFocal, 2));
  EXPECT_EQ(set.layout().FirstBlock(ParameterKind::kFocal, 1),
            set.layout().FirstBlock(ParameterKind::kFocal, 3));
  EXPECT_EQ(set.layout().FirstBlock(ParameterKind::kFocal, 4), -1);
  EXPECT_EQ(set.NumScalars(), 3U * 3U + 2U * 2U);
}

TEST(ParameterSet, MapsLogarithmsAndBoundsThere) {
  const renderer::Scene scene = tests::BallAndWall();  // the lamp is 4, 3, 2
  const ParameterSet set(scene, Unknowns(), {1, 0}, {0}, {{1.0}, 0.3, 3.0});
  const std::vector<double> theta = set.ThetaFromValues(set.layout().Gather(scene));
  EXPECT_DOUBLE_EQ(theta[0], std::log(3.5));  // moved into the bound
  EXPECT_DOUBLE_EQ(theta[1], std::log(3.0));
  EXPECT_FALSE(set.InsideBounds(theta)[0]);
  EXPECT_TRUE(set.InsideBounds(theta)[1]);
  EXPECT_DOUBLE_EQ(theta[3], 0.0);
  EXPECT_DOUBLE_EQ(set.Upper(3), 3.0 * std::log(2.0));
  const std::vector<double> values = set.ValuesFromTheta(theta);
  EXPECT_DOUBLE_EQ(values[1], 3.0);
  EXPECT_DOUBLE_EQ(set.Slope(1, values[1]), 3.0);
}

TEST(ParameterSet, RoundingLeavesNoBoundOfALogarithm) {
  const renderer::Scene scene = tests::BallAndWall();
  for (const double bound : {0.03, 0.1, 0.6, 3.3}) {
    std::vector<UnknownSpec> unknowns = Unknowns();
    unknowns[1].lower = bound;
    unknowns[1].upper = 1.7 * bound;
    const ParameterSet set(scene, unknowns, {1}, {0}, {});
    std::vector<double> theta(set.NumScalars());
    for (std::size_t i = 0; i < theta.size(); ++i) {
      theta[i] = i % 2 == 0 ? set.Lower(i) : set.Upper(i);
    }
    const std::vector<double> values = set.ValuesFromTheta(theta);
    EXPECT_GE(std::ranges::min(values), bound);
    EXPECT_LE(std::ranges::max(values), 1.7 * bound);
  }
}

TEST(ParameterSet, WhatStartsOutsideOfItsBoundsIsMovedIntoThem) {
  renderer::Scene scene = tests::BallAndWall();  // the lamp is 4, 3, 2
  std::vector<UnknownSpec> unknowns = Unknowns();
  unknowns[1].lower = 2.5;
  unknowns[3].lower = 0.9;  // held
  const renderer::Material held = scene.materials[1];
  optim::MoveIntoBounds(unknowns, scene);
  EXPECT_EQ(std::get<renderer::PointEmitter>(scene.emitters[1].light).intensity,
            (renderer::Rgb{3.5, 3.0, 2.5}));
  EXPECT_EQ(std::get<renderer::MetallicRoughnessBsdf>(scene.materials[1].bsdf).roughness,
            std::get<renderer::MetallicRoughnessBsdf>(held.bsdf).roughness);
}

TEST(ParameterSet, KeepsTheInnerAngleOfASpotBelowTheOuter) {
  renderer::Scene scene = tests::BallAndWall();
  renderer::SpotEmitter spot;
  spot.inner_angle = 0.2;
  spot.outer_angle = 0.5;
  scene.emitters[1].light = spot;
  std::vector<UnknownSpec> unknowns(2);
  unknowns[0].kind = ParameterKind::kSpotAngles;
  unknowns[0].object = 1;
  unknowns[1].kind = ParameterKind::kFocal;
  unknowns[1].object = -1;
  const ParameterSet set(scene, unknowns, {0, 1}, {0}, {});
  EXPECT_TRUE(set.IsCone(0));
  EXPECT_FALSE(set.IsCone(1));
  std::vector<double> theta = set.ThetaFromValues(set.layout().Gather(scene));
  EXPECT_NEAR(theta[0], (1.0 - std::cos(0.2)) / (1.0 - std::cos(0.5)), 1e-14);
  EXPECT_EQ(theta[1], 0.5);
  EXPECT_NEAR(set.ValuesFromTheta(theta)[0], 0.2, 1e-14);
  const std::array<double, 2> slopes = ParameterSet::ConeSlopes(0.2, 0.5);
  for (std::size_t i = 0; i < 2; ++i) {
    std::vector<double> above = theta;
    std::vector<double> below = theta;
    above[i] += 1e-5;
    below[i] -= 1e-5;
    const double difference = set.ValuesFromTheta(above)[0] - set.ValuesFromTheta(below)[0];
    EXPECT_NEAR(slopes[i], difference / 2e-5, 1e-8);
  }
  theta[1] = 0.1;
  const std::vector<double> values = set.ValuesFromTheta(theta);
  EXPECT_LT(values[0], values[1]);
  EXPECT_EQ(values[2], scene.sensors[0].fx);
  EXPECT_LT(set.Upper(0), 1.0);
  EXPECT_LT(set.Upper(1), 1.5708);
}

TEST(ParameterSet, LightsThatAreTheSameAllAroundDoNotTurnAboutTheirAxis) {
  renderer::Scene scene = tests::BallAndWall();
  scene.emitters.resize(3);
  scene.emitters[0].light = renderer::DirectionalEmitter{{0.6, 0.0, -0.8}};
  renderer::SpotEmitter spot;
  spot.frame_from_light = renderer::RotationFromVector({0.0, 0.5, 0.0});
  scene.emitters[1].light = spot;
  scene.emitters[2].light = renderer::ProjectorEmitter{};
  std::vector<UnknownSpec> unknowns(3);
  for (int i = 0; i < 3; ++i) {
    unknowns[static_cast<std::size_t>(i)].kind = ParameterKind::kLightRotation;
    unknowns[static_cast<std::size_t>(i)].object = i;
  }
  const ParameterSet set(scene, unknowns, {0, 1, 2}, {0}, {});
  ASSERT_NE(set.TurnOf(0), nullptr);
  EXPECT_EQ(set.TurnOf(0)->axis, (renderer::Vec3{0.6, 0.0, -0.8}));
  ASSERT_NE(set.TurnOf(1), nullptr);
  EXPECT_NEAR(set.TurnOf(1)->axis.x, -std::sin(0.5), 1e-15);
  EXPECT_EQ(set.TurnOf(2), nullptr) << "a picture shows how it turns";
  const std::vector<double> from = set.layout().Gather(scene);
  std::vector<double> to = from;
  for (double& x : to) x += 0.5;
  set.DropTurnsAboutAxes(from, to);
  EXPECT_NEAR(0.6 * to[0] - 0.8 * to[2], 0.0, 1e-15);
  EXPECT_EQ(to[1], 0.5);
  EXPECT_EQ(to[8], 0.5);
}

TEST(ParameterSet, FreesCamerasOfAllSensorsThatAreFitted) {
  renderer::Scene scene = tests::BallAndWall();
  scene.sensors.resize(3, scene.sensors.front());
  std::vector<UnknownSpec> unknowns(1);
  unknowns[0].kind = ParameterKind::kCameraRotation;
  unknowns[0].object = -1;
  const ParameterSet set(scene, unknowns, {0}, {0, 2}, {});
  ASSERT_EQ(set.layout().groups().size(), 2U);
  EXPECT_EQ(set.layout().groups()[1].object, 2);
}

TEST(ParameterSet, RefusesUnknownsThatDoNotExist) {
  const renderer::Scene scene = tests::BallAndWall();
  std::vector<UnknownSpec> unknowns = Unknowns();
  EXPECT_THROW(ParameterSet(scene, unknowns, {7}, {}, {}), renderer::SceneError);
  unknowns[1].object = 12;
  EXPECT_THROW(ParameterSet(scene, unknowns, {1}, {}, {}), renderer::SceneError);
  EXPECT_THROW(ParameterSet(scene, unknowns, {2, 2}, {}, {}), renderer::SceneError);
}

}  // namespace
}  // namespace pathfit::parameter_set_test
