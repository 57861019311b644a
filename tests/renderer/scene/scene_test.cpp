#include "renderer/scene/scene.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer {
namespace {

/// The scene is refused and the message names the culprit.
void ExpectRefused(const std::function<void(Scene&)>& spoil, const std::string& name) {
  Scene scene = tests::BallAndWall();
  spoil(scene);
  try {
    ValidateScene(scene);
    ADD_FAILURE() << "accepted, expected a message with " << name;
  } catch (const SceneError& e) {
    EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
  }
}

TEST(ValidateScene, AcceptsTheTestScene) {
  EXPECT_NO_THROW(ValidateScene(tests::BallAndWall()));
  EXPECT_NO_THROW(ValidateScene(Scene{}));
}

TEST(ValidateScene, RefusesBadMaterials) {
  ExpectRefused([](Scene& s) { s.meshes[0].material = 7; }, "'ball'");
  ExpectRefused([](Scene& s) { s.materials[1].base_color.g = -0.1; }, "'gloss'");
  ExpectRefused([](Scene& s) { s.materials[1].base_color.g = std::nan(""); }, "'gloss'");
  ExpectRefused(
      [](Scene& s) { std::get<MetallicRoughnessBsdf>(s.materials[1].bsdf).roughness = 0.01; },
      "'gloss'");
  ExpectRefused(
      [](Scene& s) { std::get<MetallicRoughnessBsdf>(s.materials[1].bsdf).metallic = 1.5; },
      "'gloss'");
}

TEST(ValidateScene, RefusesBadVertexColors) {
  ExpectRefused([](Scene& s) { s.meshes[0].mesh.color_triangles.clear(); }, "'ball'");
  ExpectRefused([](Scene& s) { s.meshes[0].mesh.color_triangles.pop_back(); }, "'ball'");
  ExpectRefused([](Scene& s) { s.meshes[0].mesh.colors[3].r = INFINITY; }, "'ball'");
  ExpectRefused([](Scene& s) { s.meshes[0].mesh.color_triangles[2][1] = 100000; }, "'ball'");
}

TEST(ValidateScene, RefusesBadMeshes) {
  ExpectRefused([](Scene& s) { s.meshes[1].mesh.positions[0].y = std::nan(""); }, "'wall'");
  ExpectRefused([](Scene& s) { s.meshes[1].mesh.triangles.clear(); }, "'wall'");
  ExpectRefused([](Scene& s) { s.meshes[1].mesh.triangles[0] = {0, 1, 1}; }, "'wall'");
}

TEST(ValidateScene, RefusesBadLights) {
  ExpectRefused(
      [](Scene& s) { std::get<EnvironmentEmitter>(s.emitters[0].light).texels.pop_back(); },
      "'sky'");
  ExpectRefused(
      [](Scene& s) { std::get<EnvironmentEmitter>(s.emitters[0].light).texels[5].b = -1.0; },
      "'sky'");
  ExpectRefused([](Scene& s) { std::get<EnvironmentEmitter>(s.emitters[0].light).width = 0; },
                "'sky'");
  ExpectRefused([](Scene& s) { std::get<PointEmitter>(s.emitters[1].light).position.x = INFINITY; },
                "'lamp'");
  ExpectRefused([](Scene& s) { LightIntensity(s.emitters[1]).r = -1.0; }, "'lamp'");
  ExpectRefused(
      [](Scene& s) {
        std::get<DirectionalEmitter>(s.emitters[2].light).direction = {0, 0, 2};
      },
      "'sun'");
  ExpectRefused(
      [](Scene& s) {
        s.emitters.push_back(tests::ConstantEnvironment({1, 1, 1}));
      },
      "one environment");
}

TEST(ValidateScene, RefusesBadSensors) {
  ExpectRefused([](Scene& s) { s.sensors[0].fx = -1.0; }, "'camera'");
}

}  // namespace
}  // namespace pathfit::renderer
