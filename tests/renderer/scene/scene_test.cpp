#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_normals.h"
#include "renderer/scene/world.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer::scene_test {
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
  ExpectRefused(
      [](Scene& s) { std::get<MetallicRoughnessBsdf>(s.materials[1].bsdf).specular = 1.5; },
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

/// The value with one member changed.
template <class T, class Member>
T With(T value, Member T::*member, const Member& replacement) {
  value.*member = replacement;
  return value;
}

Emitter Light(decltype(Emitter::light) light) {
  Emitter emitter;
  emitter.name = "new";
  emitter.light = std::move(light);
  return emitter;
}

/// BallAndWall with a texture of 2 x 1 texels, scalar and colour.
Scene TexturedScene() {
  Scene scene = tests::BallAndWall();
  scene.textures.resize(2);
  scene.textures[0].name = "paper";
  scene.textures[1].name = "worn";
  scene.textures[1].scalar = true;
  for (Texture& texture : scene.textures) {
    texture.width = 2;
    texture.texels = {Rgb::Constant(0.25), Rgb::Constant(0.75)};
  }
  scene.materials[1].base_color_texture = 0;
  scene.materials[1].roughness_texture = 1;
  scene.materials[1].metallic_texture = 1;
  scene.emitters.push_back(
      Light(With(With(AreaEmitter{}, &AreaEmitter::mesh, 1), &AreaEmitter::texture, 0)));
  scene.emitters.push_back(Light(With(ProjectorEmitter{}, &ProjectorEmitter::texture, 0)));
  scene.emitters.push_back(Light(SpotEmitter{}));
  scene.meshes[0].pose = {{1, 0, 0}, {0, 2, 0}, {0.1, 0.2, 0.3}, 0.5};
  return scene;
}

/// As ExpectRefused, from the textured scene.
void ExpectTexturedRefused(const std::function<void(Scene&)>& spoil, const std::string& name) {
  ExpectRefused(
      [&](Scene& s) {
        s = TexturedScene();
        spoil(s);
      },
      name);
}

TEST(ValidateScene, AcceptsTexturesPosesAndAllLights) {
  EXPECT_NO_THROW(ValidateScene(TexturedScene()));
}

TEST(ValidateScene, RefusesBadTextures) {
  ExpectTexturedRefused([](Scene& s) { s.textures[0].texels.pop_back(); }, "'paper'");
  ExpectTexturedRefused([](Scene& s) { s.textures[0].height = 0; }, "'paper'");
  ExpectTexturedRefused([](Scene& s) { s.textures[0].width = s.textures[0].height = 1 << 20; },
                        "'paper'");
  ExpectTexturedRefused([](Scene& s) { s.textures[0].texels[1].g = std::nan(""); }, "'paper'");
  ExpectTexturedRefused([](Scene& s) { s.textures[0].texels[1].g = -0.1; }, "'paper'");
  ExpectTexturedRefused([](Scene& s) { s.textures[1].texels[0].g = 0.5; }, "equal channels");
  ExpectTexturedRefused([](Scene& s) { s.materials[1].base_color_texture = 2; },
                        "'gloss': its base colour texture does not exist");
  ExpectTexturedRefused([](Scene& s) { s.materials[1].roughness_texture = -2; }, "roughness");
  ExpectTexturedRefused([](Scene& s) { s.materials[1].roughness_texture = 0; }, "scalar");
  ExpectTexturedRefused([](Scene& s) { s.textures[1].texels[0] = Rgb::Constant(0.02); },
                        "roughness texture 'worn' must lie in [0.03, 1]");
  ExpectTexturedRefused([](Scene& s) { s.textures[1].texels[0] = Rgb::Constant(1.5); }, "'worn'");
  ExpectTexturedRefused([](Scene& s) { s.materials[1].bsdf = LambertBsdf{}; }, "no roughness");
  ExpectTexturedRefused([](Scene& s) { s.materials[1].bsdf = RoughConductorBsdf{}; },
                        "no metallic");
  ExpectTexturedRefused([](Scene& s) { s.materials[1].vertex_colors = true; }, "either");
  ExpectTexturedRefused(
      [](Scene& s) {
        s.emitters.clear();
        s.meshes[1].mesh.uvs.clear();
        s.meshes[1].mesh.uv_triangles.clear();
      },
      "'wall': its material has a texture, the mesh has no UVs");
}

TEST(ValidateScene, RefusesBadModels) {
  const auto refused = [](const Bsdf& bsdf) {
    ExpectRefused([&](Scene& s) { s.materials[1].bsdf = bsdf; }, "'gloss'");
  };
  const double nan = std::nan("");
  refused(With(RoughConductorBsdf{}, &RoughConductorBsdf::roughness, 0.02));
  refused(With(RoughConductorBsdf{}, &RoughConductorBsdf::eta, Rgb{1, -1, 1}));
  refused(With(RoughConductorBsdf{}, &RoughConductorBsdf::k, Rgb{1, 1, nan}));
  refused(With(RoughDielectricBsdf{}, &RoughDielectricBsdf::roughness, nan));
  refused(With(RoughDielectricBsdf{}, &RoughDielectricBsdf::eta, 1.0));
  refused(With(RoughDielectricBsdf{}, &RoughDielectricBsdf::eta, 0.0));
  refused(With(MirrorBsdf{}, &MirrorBsdf::eta, Rgb{nan, 0, 0}));
  refused(With(SmoothDielectricBsdf{}, &SmoothDielectricBsdf::eta, -1.5));
  Scene scene = tests::BallAndWall();
  for (const Bsdf& bsdf : {Bsdf{RoughConductorBsdf{}},
                           Bsdf{RoughDielectricBsdf{}},
                           Bsdf{MirrorBsdf{}},
                           Bsdf{With(SmoothDielectricBsdf{}, &SmoothDielectricBsdf::eta, 0.7)}}) {
    scene.materials[1].bsdf = bsdf;
    EXPECT_NO_THROW(ValidateScene(scene));
  }
}

TEST(ValidateScene, RefusesBadEmitters) {
  const auto refused = [](const Emitter& emitter, const std::string& name) {
    ExpectRefused([&](Scene& s) { s.emitters.push_back(emitter); }, name);
  };
  const Mat3 scaled = {{2, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Mat3 mirrored = {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  refused(Light(With(
              With(SpotEmitter{}, &SpotEmitter::inner_angle, 0.5), &SpotEmitter::outer_angle, 0.5)),
          "inner < outer");
  refused(Light(With(SpotEmitter{}, &SpotEmitter::inner_angle, -0.1)), "inner < outer");
  refused(Light(With(SpotEmitter{}, &SpotEmitter::outer_angle, 1.6)), "inner < outer");
  refused(Light(With(SpotEmitter{}, &SpotEmitter::outer_angle, std::nan(""))), "inner < outer");
  refused(Light(With(SpotEmitter{}, &SpotEmitter::position, Vec3{0, INFINITY, 0})), "position");
  refused(Light(With(SpotEmitter{}, &SpotEmitter::frame_from_light, scaled)), "rotation");
  refused(Light(With(ProjectorEmitter{}, &ProjectorEmitter::frame_from_light, mirrored)),
          "rotation");
  refused(Light(With(ProjectorEmitter{}, &ProjectorEmitter::tan_half_width, 0.0)), "width");
  refused(Light(With(ProjectorEmitter{}, &ProjectorEmitter::texture, 0)),
          "'new': its projected texture does not exist");
  refused(Light(AreaEmitter{}), "'new': its mesh does not exist");
  refused(Light(With(AreaEmitter{}, &AreaEmitter::mesh, 2)), "its mesh does not exist");
  refused(Light(With(With(AreaEmitter{}, &AreaEmitter::mesh, 1), &AreaEmitter::texture, 0)),
          "texture does not exist");
  refused(Light(With(
              With(AreaEmitter{}, &AreaEmitter::mesh, 1), &AreaEmitter::intensity, Rgb{1, -1, 1})),
          "intensity");
  Emitter turned = Light(With(AreaEmitter{}, &AreaEmitter::mesh, 1));
  turned.rotation = {0, 0.1, 0};
  refused(turned, "no rotation");
  Emitter carried = Light(With(AreaEmitter{}, &AreaEmitter::mesh, 1));
  carried.frame = LightFrame::kCamera;
  refused(carried, "stands in the world");
  Emitter lost = Light(SpotEmitter{});
  lost.rotation.y = std::nan("");
  refused(lost, "rotation must be finite");
  ExpectTexturedRefused(
      [](Scene& s) { s.emitters.push_back(Light(With(AreaEmitter{}, &AreaEmitter::mesh, 1))); },
      "mesh 'wall' shines by another area light");
  ExpectTexturedRefused(
      [](Scene& s) {
        s.materials[1] = s.materials[0];
        s.materials[1].vertex_colors = false;
        s.meshes[1].mesh.uv_triangles.clear();
      },
      "'new': it has a texture, mesh 'wall' has no UVs");
}

TEST(ValidateScene, RefusesBadPoses) {
  ExpectRefused([](Scene& s) { s.meshes[0].pose.scale = 0.0; }, "'ball'");
  ExpectRefused([](Scene& s) { s.meshes[0].pose.scale = -1.0; }, "'ball'");
  ExpectRefused([](Scene& s) { s.meshes[0].pose.scale = INFINITY; }, "'ball'");
  ExpectRefused([](Scene& s) { s.meshes[0].pose.rotation.x = std::nan(""); }, "'ball'");
  ExpectRefused([](Scene& s) { s.meshes[0].pose.pivot.x = INFINITY; }, "'ball'");
  ExpectRefused([](Scene& s) { s.meshes[0].pose.translation.x = 1e30; }, "1e12");
  ExpectRefused([](Scene& s) { s.meshes[0].pose.scale = 1e20; }, "1e12");
}

TEST(ValidateScene, RefusesBadSensors) {
  ExpectRefused([](Scene& s) { s.sensors[0].fx = -1.0; }, "'camera'");
}

TEST(WorldMesh, IdentityPoseChangesNoBit) {
  SceneMesh mesh;
  mesh.mesh = MakeIcosphere(1, 0.3);
  mesh.pose.pivot = {1.0 / 3.0, 7.1, -0.1};
  EXPECT_EQ(WorldMesh(mesh).positions, mesh.mesh.positions);
}

TEST(WorldMesh, ScalesAndTurnsAboutThePivotThenTranslates) {
  SceneMesh mesh;
  mesh.mesh.positions = {{1, 2, 3}, {2, 2, 3}, {1, 3, 3}};
  mesh.mesh.triangles = {{0, 1, 2}};
  mesh.mesh.normals = {{0, 0, 2}, {1, 0, 0}, {0, 1, 0}};
  mesh.mesh.normal_triangles = {{0, 1, 2}};
  // A quarter turn about y takes x to -z and z to x.
  mesh.pose = {{1, 2, 3}, {10, 0, 0}, {0, 1.5707963267948966, 0}, 2.0};
  const Mesh world = WorldMesh(mesh);
  const auto expect_near = [](const Vec3& a, const Vec3& b) { EXPECT_LT(Norm(a - b), 1e-14); };
  expect_near(world.positions[0], {11, 2, 3});
  expect_near(world.positions[1], {11, 2, 1});
  expect_near(world.positions[2], {11, 4, 3});
  // Normals turn, and keep their lengths.
  expect_near(world.normals[0], {2, 0, 0});
  expect_near(world.normals[1], {0, 0, -1});
  expect_near(world.normals[2], {0, 1, 0});
  EXPECT_EQ(world.triangles, mesh.mesh.triangles);
}

TEST(WorldMesh, PoseCommutesWithSmoothNormals) {
  SceneMesh mesh;
  mesh.mesh = MakeIcosphere(1, 1.0);
  mesh.mesh.positions[3] *= 1.4;
  mesh.pose = {{0.2, 0, 0}, {1, -2, 0.5}, {0.4, -1.1, 0.7}, 0.3};
  ComputeVertexNormals(mesh.mesh);
  const Mesh world = WorldMesh(mesh);
  Mesh again = world;
  ComputeVertexNormals(again);
  for (std::size_t i = 0; i < world.normals.size(); ++i) {
    EXPECT_LT(Norm(world.normals[i] - again.normals[i]), 1e-13);
  }
}

TEST(World, PutsMeshesIntoTheWorldAndKeepsTheScene) {
  const Scene scene = TexturedScene();
  const World world(scene);
  ASSERT_EQ(world.NumMeshes(), static_cast<int>(scene.meshes.size()));
  EXPECT_EQ(world.mesh(0).positions, WorldMesh(scene.meshes[0]).positions);
  EXPECT_NE(world.mesh(0).positions, scene.meshes[0].mesh.positions);
  EXPECT_EQ(world.mesh(1).positions, scene.meshes[1].mesh.positions);
  EXPECT_EQ(world.scene().meshes[0].mesh.positions, scene.meshes[0].mesh.positions);
  EXPECT_EQ(world.scene().meshes[0].pose, scene.meshes[0].pose);
}

}  // namespace
}  // namespace pathfit::renderer::scene_test
