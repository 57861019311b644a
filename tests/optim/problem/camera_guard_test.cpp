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
  const optim::CameraGuard guard(scene, set);
  const std::vector<double> start = set.layout().Gather(scene);
  const auto admits = [&](ParameterKind kind, int object, double value) {
    std::vector<double> values = start;
    values[set.BlockOffset(set.layout().FirstBlock(kind, object))] = value;
    return guard.Admits(values);
  };
  EXPECT_TRUE(guard.Admits(start));
  EXPECT_TRUE(admits(ParameterKind::kFocal, 1, 40.0));
  EXPECT_FALSE(admits(ParameterKind::kFocal, 1, -1.0));
  EXPECT_FALSE(admits(ParameterKind::kFocal, 0, std::numeric_limits<double>::quiet_NaN()));
  EXPECT_TRUE(admits(ParameterKind::kRadialDistortion, 1, 0.01));
  EXPECT_FALSE(admits(ParameterKind::kRadialDistortion, 1, -5.0)) << "folds";
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
  const optim::CameraGuard guard(scene, set);
  EXPECT_TRUE(guard.Admits({-0.01, 0.0, 0.0}));
  EXPECT_FALSE(guard.Admits({-10.0, 0.0, 0.0})) << "too dark in the second";
}

}  // namespace
}  // namespace pathfit::camera_guard_test
