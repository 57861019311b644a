#include "optim/problem/camera_guard.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/support/test_scenes.h"

namespace pathfit::camera_guard_test {
namespace {

using renderer::ParameterKind;

TEST(CameraGuard, RefusesCamerasThatCannotRender) {
  renderer::Scene scene = tests::BallAndWall();
  scene.sensors.resize(2, scene.sensors.front());
  std::vector<optim::UnknownSpec> unknowns(3);
  unknowns[0].kind = ParameterKind::kVertexPositions;
  unknowns[1].kind = ParameterKind::kFocal;
  unknowns[1].object = -1;
  unknowns[2].kind = ParameterKind::kRadialDistortion;
  unknowns[2].object = 1;
  const optim::ParameterSet set(scene, unknowns, {0, 1, 2}, {0, 1}, {});
  const std::vector<double> start = set.layout().Gather(scene);
  const optim::CameraGuard guard(scene, set, start);
  const auto admits = [&](ParameterKind kind, int object, double value) {
    std::vector<double> values = start;
    values[set.BlockOffset(set.layout().FirstBlock(kind, object))] = value;
    const std::vector<double> wanted = values;
    return guard.Restrain(values) && values == wanted;
  };
  std::vector<double> same = start;
  EXPECT_TRUE(guard.Restrain(same));
  EXPECT_EQ(same, start);
  EXPECT_TRUE(admits(ParameterKind::kFocal, 1, 40.0));
  EXPECT_FALSE(admits(ParameterKind::kFocal, 1, -1.0));
  EXPECT_FALSE(admits(ParameterKind::kFocal, 0, std::numeric_limits<double>::quiet_NaN()));
  EXPECT_TRUE(admits(ParameterKind::kRadialDistortion, 1, 0.01));
  EXPECT_FALSE(admits(ParameterKind::kRadialDistortion, 1, -5.0)) << "folds";
}

TEST(CameraGuard, LensesGoTowardsTheirBorderAndAllOthersKeepTheirStep) {
  renderer::Scene scene = tests::BallAndWall();
  std::vector<optim::UnknownSpec> unknowns(2);
  unknowns[0].kind = ParameterKind::kFocal;
  unknowns[1].kind = ParameterKind::kRadialDistortion;
  const optim::ParameterSet set(scene, unknowns, {0, 1}, {0}, {});
  std::vector<double> values = set.layout().Gather(scene);
  const std::size_t focal = set.BlockOffset(set.layout().FirstBlock(ParameterKind::kFocal, 0));
  const std::size_t lens =
      set.BlockOffset(set.layout().FirstBlock(ParameterKind::kRadialDistortion, 0));
  std::vector<double> reached;
  for (int round = 0; round < 3; ++round) {
    const optim::CameraGuard guard(scene, set, values);
    values[focal] += 0.01;
    values[lens] = -5.0;
    const double wanted = values[focal];
    ASSERT_TRUE(guard.Restrain(values));
    EXPECT_EQ(values[focal], wanted);
    reached.push_back(values[lens]);
    set.layout().Scatter(values, scene);
    EXPECT_NO_THROW(renderer::CameraModel(scene.sensors[0]));
  }
  EXPECT_LT(reached[0], -0.1);
  EXPECT_LT(reached[1], reached[0]);
  EXPECT_LT(reached[2], reached[1]) << "never so near that nothing is left";
}

TEST(CameraGuard, LooksAtAllThatShareALens) {
  renderer::Scene scene = tests::BallAndWall();
  scene.sensors.resize(2, scene.sensors.front());
  scene.sensors[1].cx += 3.0 * scene.sensors[1].width;  // its corners are farther away
  std::vector<optim::UnknownSpec> unknowns(1);
  unknowns[0].kind = ParameterKind::kVignetting;
  unknowns[0].object = -1;
  unknowns[0].sharing = {0, 0};
  const optim::ParameterSet set(scene, unknowns, {0}, {0, 1}, {});
  const optim::CameraGuard guard(scene, set, {0.0, 0.0, 0.0});
  std::vector<double> light = {-0.01, 0.0, 0.0}, dark = {-10.0, 0.0, 0.0};
  EXPECT_TRUE(guard.Restrain(light));
  EXPECT_EQ(light[0], -0.01);
  EXPECT_TRUE(guard.Restrain(dark));
  EXPECT_GT(dark[0], -10.0) << "too dark in the second";
}

}  // namespace
}  // namespace pathfit::camera_guard_test
