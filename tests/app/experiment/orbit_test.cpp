#include "app/experiment/orbit.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/optim/round/synthetic_fit.h"

namespace pathfit::app::orbit_test {
namespace {

using renderer::Camera;
using renderer::Mat3;
using renderer::Vec3;

constexpr double kTight = 1e-9;

/// Cameras that look down at a ball from the half circle of these angles about `up`.
renderer::Scene Arc(const Vec3& up, double height) {
  renderer::Scene scene = tests::BallScene(1, 5, 64);
  const Vec3 x = Normalized(Cross(up, Vec3{0.3, 0.5, -0.8}));
  const Vec3 y = Cross(up, x);
  for (std::size_t i = 0; i < scene.sensors.size(); ++i) {
    const double angle = 0.6 * static_cast<double>(i);
    const Vec3 origin = x * (4.0 * std::cos(angle)) + y * (4.0 * std::sin(angle)) + up * height;
    scene.sensors[i].world_from_camera = renderer::LookAt(origin, {0.0, 0.0, 0.0}, up);
  }
  return scene;
}

TEST(UpDirection, IsWhatLevelCamerasHoldUp) {
  const Vec3 up = Normalized(Vec3{0.4, -0.7, 0.6});
  // On an arc, the mean of the cameras' own up leans.
  EXPECT_LT(Norm(UpDirection(Arc(up, 2.5)) - up), 1e-6);
  EXPECT_EQ(UpDirection(Arc(Normalized(Vec3{0.01, 0.0, -1.0}), 2.5)), (Vec3{0.0, 0.0, -1.0}));
  EXPECT_EQ(UpDirection({}), (Vec3{0.0, 1.0, 0.0}));
}

TEST(Orbit, KeepsHeightDistanceAndSight) {
  const Vec3 up{0.0, 0.0, 1.0};
  renderer::Scene scene = Arc(up, 3.0);
  for (Camera& camera : scene.sensors) camera.gain = 4.0;
  scene.sensors[1].gain = 0.25;
  const std::vector<Camera> orbit = OrbitCameras(scene, 8);
  ASSERT_EQ(orbit.size(), 8U);
  for (const Camera& camera : orbit) {
    const Vec3& origin = camera.world_from_camera.translation;
    EXPECT_NEAR(origin.z, 3.0, kTight);
    EXPECT_NEAR(Norm(origin), 5.0, kTight);
    EXPECT_LT(Norm(camera.world_from_camera.linear.z - Normalized(origin)), kTight)
        << "to the middle";
    EXPECT_NEAR(camera.world_from_camera.linear.x.z, 0.0, kTight) << "level";
    EXPECT_NEAR(camera.gain, std::exp2((4 * 2.0 - 2.0) / 5.0), kTight);
    EXPECT_EQ(camera.cx, 32.0);
  }
  EXPECT_LT(
      Norm(orbit[0].world_from_camera.translation - scene.sensors[0].world_from_camera.translation),
      1e-6)
      << "begins at the first camera";
  const Vec3 a = orbit[0].world_from_camera.translation, b = orbit[1].world_from_camera.translation;
  EXPECT_NEAR(Dot(Cross(a, b), up) / (16.0 * std::sin(0.25 * std::numbers::pi)), 1.0, 1e-6)
      << "against the clock";
  EXPECT_EQ(orbit[3].name, "orbit_003");
}

TEST(Orbit, LeavesTheMiddleOfTheMeshes) {
  renderer::Scene scene = Arc({0.0, 1.0, 0.0}, 0.0);
  scene.sensors.resize(1);
  scene.sensors[0].world_from_camera.translation = {0.0, 0.0, 0.0};
  for (const auto kind :
       {renderer::ProjectionKind::kPerspective, renderer::ProjectionKind::kOrthographic}) {
    scene.sensors[0].projection = kind;
    for (const Camera& camera : OrbitCameras(scene, 3)) {
      EXPECT_GT(Norm(camera.world_from_camera.translation), 0.5);
      EXPECT_TRUE(std::isfinite(camera.world_from_camera.linear.x.x));
    }
  }
}

TEST(Orbit, StandsBackUntilTheMeshesFit) {
  renderer::Scene scene = Arc({0.0, 1.0, 0.0}, 0.0);
  for (Camera& camera : scene.sensors) camera.fx = camera.fy = 600.0;
  for (const Camera& camera : OrbitCameras(scene, 5)) {
    const renderer::CameraModel model(camera);
    for (const Vec3& p : scene.meshes[0].mesh.positions) {
      const auto seen = model.Project(p);
      ASSERT_TRUE(seen);
      EXPECT_GT(std::min(seen->u, seen->v), 0.0);
      EXPECT_LT(std::max(seen->u, seen->v), 64.0);
    }
  }
}

TEST(Orbit, LooksDownFromNoStraightAbove) {
  renderer::Scene scene = Arc({0.0, 1.0, 0.0}, 0.5);
  for (Camera& camera : scene.sensors) camera.world_from_camera.translation = {0.0, 9.0, 1e-3};
  for (const Camera& camera : OrbitCameras(scene, 3)) {
    EXPECT_LT(camera.world_from_camera.translation.y, 0.99 * 9.0);
  }
}

TEST(Orbit, NeedsSomethingToGoRound) {
  renderer::Scene scene = Arc({0.0, 1.0, 0.0}, 0.5);
  scene.meshes.clear();
  EXPECT_THROW(OrbitCameras(scene, 3), renderer::SceneError);
}

}  // namespace
}  // namespace pathfit::app::orbit_test
