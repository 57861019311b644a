#include "renderer/scene/light_set.h"

#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/test_scenes.h"

namespace pathfit::renderer {
namespace {

constexpr double kRounding = 1e-14;

Scene SceneWithLights(LightFrame frame) {
  Scene scene = tests::BallAndWall();
  for (Emitter& e : scene.emitters) e.frame = frame;
  std::get<EnvironmentEmitter>(scene.emitters[0].light).frame_from_light =
      RotationAboutAxis(Normalized(Vec3{1, 2, 3}), 0.8);
  return scene;
}

TEST(LightSet, WorldLightsIgnoreTheCamera) {
  const Scene scene = SceneWithLights(LightFrame::kWorld);
  const EnvironmentSampler sampler(std::get<EnvironmentEmitter>(scene.emitters[0].light));
  const Transform camera = LookAt({3, 2, 1}, {0, 0, 0}, {0, 1, 0});
  const LightSet set = LightSet::Make(scene, &sampler, camera);
  ASSERT_EQ(set.points.size(), 1U);
  ASSERT_EQ(set.directionals.size(), 1U);
  ASSERT_TRUE(set.environment.has_value());
  EXPECT_EQ(set.points[0].position, std::get<PointEmitter>(scene.emitters[1].light).position);
  EXPECT_EQ(set.points[0].emitter, 1);
  EXPECT_EQ(set.directionals[0].to_light,
            -std::get<DirectionalEmitter>(scene.emitters[2].light).direction);
  EXPECT_EQ(set.environment->world_from_light,
            std::get<EnvironmentEmitter>(scene.emitters[0].light).frame_from_light);
}

TEST(LightSet, CameraLightsTurnAndMoveWithTheCamera) {
  const Scene scene = SceneWithLights(LightFrame::kCamera);
  const EnvironmentSampler sampler(std::get<EnvironmentEmitter>(scene.emitters[0].light));
  const Transform camera{RotationAboutAxis({0, 1, 0}, 0.5 * std::numbers::pi), {1, 2, 3}};
  const LightSet set = LightSet::Make(scene, &sampler, camera);
  const Vec3 position = std::get<PointEmitter>(scene.emitters[1].light).position;
  EXPECT_NEAR(Norm(set.points[0].position - Vec3{1 + position.z, 2 + position.y, 3 - position.x}),
              0.0,
              kRounding);
  const Vec3 direction = std::get<DirectionalEmitter>(scene.emitters[2].light).direction;
  EXPECT_NEAR(Norm(set.directionals[0].to_light + Vec3{direction.z, direction.y, -direction.x}),
              0.0,
              kRounding);
  const Vec3 d{0.36, 0.48, -0.8};
  const Vec3 in_world = set.environment->world_from_light * d;
  const Vec3 in_camera = std::get<EnvironmentEmitter>(scene.emitters[0].light).frame_from_light * d;
  EXPECT_NEAR(Norm(in_world - camera.Direction(in_camera)), 0.0, kRounding);
  EXPECT_NEAR(Norm(set.environment->light_from_world * in_world - d), 0.0, kRounding);
}

}  // namespace
}  // namespace pathfit::renderer
