#include "optim/parameter/parameter_set.h"

#include <cmath>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/support/test_scenes.h"

namespace pathfit {
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

TEST(ParameterSet, MapsLogarithmsAndBoundsThere) {
  const renderer::Scene scene = tests::BallAndWall();  // the lamp is 4, 3, 2
  const ParameterSet set(scene, Unknowns(), {1, 0}, {0}, {{1.0}, 0.3, 3.0});
  const std::vector<double> theta = set.ThetaFromValues(set.layout().Gather(scene));
  EXPECT_DOUBLE_EQ(theta[0], std::log(3.5));  // moved into the bound
  EXPECT_DOUBLE_EQ(theta[1], std::log(3.0));
  EXPECT_DOUBLE_EQ(theta[3], 0.0);
  EXPECT_DOUBLE_EQ(set.upper()[3], 3.0 * std::log(2.0));
  const std::vector<double> values = set.ValuesFromTheta(theta);
  EXPECT_DOUBLE_EQ(values[1], 3.0);
  EXPECT_DOUBLE_EQ(set.Slope(1, values[1]), 3.0);
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
}  // namespace pathfit
