#include "app/experiment/direction.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/experiment/experiment.h"
#include "renderer/core/error.h"
#include "tests/app/config/config_text.h"

namespace pathfit::app::direction_test {
namespace {

const renderer::Scene& TestScene() {
  static const renderer::Scene scene = BuildExperiment(LoadExperimentConfig(ConfigFile(R"(schema: 1
scene:
  geometry:
    tri: {mesh: {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 2]], uvs: [[0, 0], [1, 0], [0, 1]]}, material: gold, normals: smooth}
    lamp: {primitive: {cube: {}}, material: frost}
  materials:
    gold: {model: conductor, metal: gold, roughness: {texture: worn}}
    frost: {model: dielectric}
  textures:
    worn: {size_px: [2, 1]}
    slide: {size_px: [2, 2]}
  lights:
    sky: {type: envmap, size_px: [4, 2]}
    spot: {type: spot, position_m: [0, 0, 3], target_m: [0, 0, 0], outer_deg: 30}
    beamer: {type: projector, position_m: [0, 0, 3], target_m: [0, 0, 0], fov_deg: 30, texture: slide}
    lamp: {type: area, mesh: lamp}
  sensors:
    left: {size_px: [8, 8], focal_px: 8, pose: {look_at: {origin_m: [0, 0, 5], target_m: [0, 0, 0]}}}
    spot: {size_px: [8, 8], focal_px: 8, pose: {look_at: {origin_m: [1, 0, 5], target_m: [0, 0, 0]}}}
)")
                                                                                .path(),
                                                                            {}))
                                           .scene;
  return scene;
}

Direction Parse(const std::string& name) { return ParseDirection(TestScene(), name); }

std::string ErrorOf(const std::string& name) {
  try {
    Parse(name);
  } catch (const renderer::SceneError& error) {
    return error.what();
  }
  return {};
}

using Values = std::vector<double>;

TEST(Direction, NamesEveryKindOfParameter) {
  EXPECT_EQ(Parse("tri.vertices.y").values, (Values{0, 1, 0, 0, 1, 0, 0, 1, 0}));
  EXPECT_EQ(Parse("tri.vertices[1].z").values, (Values{0, 0, 0, 0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(Parse("tri.normals.x").values, (Values{1, 0, 0, 1, 0, 0, 1, 0, 0}));
  EXPECT_EQ(Parse("tri.uvs[2].v").values, (Values{0, 0, 0, 0, 0, 1}));
  EXPECT_EQ(Parse("tri.translation.x").values, (Values{1, 0, 0}));
  EXPECT_EQ(Parse("tri.rotation.z").values, (Values{0, 0, 1}));
  EXPECT_EQ(Parse("tri.scale").values, (Values{1}));
  EXPECT_EQ(Parse("gold.base_color").values, (Values{1, 1, 1}));
  EXPECT_EQ(Parse("gold.eta.g").values, (Values{0, 1, 0}));
  EXPECT_EQ(Parse("gold.k").values, (Values{1, 1, 1})) << "k is a property";
  EXPECT_EQ(Parse("gold.k.b").values, (Values{0, 0, 1}));
  EXPECT_EQ(Parse("frost.eta").values, (Values{1}));
  EXPECT_EQ(Parse("frost.roughness").values, (Values{1}));
  EXPECT_EQ(Parse("worn.texels[1]").values, (Values{0, 1}));
  EXPECT_EQ(Parse("slide.texels[0].r").values.size(), 12U);
  EXPECT_EQ(Parse("sky.texels.g").values.size(), 24U);
  EXPECT_EQ(Parse("sky.rotation.y").values, (Values{0, 1, 0}));
  EXPECT_EQ(Parse("spot.angles.o").values, (Values{0, 1}));
  EXPECT_EQ(Parse("beamer.position.x").values, (Values{1, 0, 0}));
  EXPECT_EQ(Parse("lamp.intensity").values, (Values{1, 1, 1})) << "the light";
  EXPECT_EQ(Parse("lamp.rotation.x").layout.groups()[0].kind,
            renderer::ParameterKind::kObjectRotation)
      << "area lights have none, so the mesh's is meant";
  EXPECT_EQ(Parse("left.position.x").values, (Values{1, 0, 0}));
  EXPECT_EQ(Parse("left.exposure").values, (Values{1}));
}

// All numbers alike, unless many are to be checked at once.
TEST(Direction, WholeFieldsWithoutAComponent) {
  EXPECT_EQ(Parse("worn.texels").values, (Values{1, 1}));
  EXPECT_EQ(Parse("tri.vertices").values, Values(9, 1.0));
  const auto random = [](const std::string& name) {
    return ParseDirection(TestScene(), name, FieldDirection::kRandom).values;
  };
  EXPECT_NE(random("worn.texels"), (Values{1, 1}));
  EXPECT_EQ(random("worn.texels[1]"), (Values{0, 1}));
  EXPECT_EQ(random("tri.vertices.x"), Parse("tri.vertices.x").values);
  EXPECT_EQ(random("gold.base_color"), (Values{1, 1, 1}));
}

TEST(Direction, CameraMeansAllSensors) {
  EXPECT_EQ(Parse("exposure").values, (Values{1, 1}));
  EXPECT_EQ(Parse("camera.rotation.y").values, (Values{0, 1, 0, 0, 1, 0}));
  EXPECT_EQ(Parse("camera.focal").values, (Values{1, 1, 1, 1}));
  EXPECT_EQ(Parse("camera.principal_point.y").values, (Values{0, 1, 0, 1}));
  EXPECT_EQ(Parse("camera.distortion.2").values, (Values{0, 1, 0, 0, 1, 0}));
  EXPECT_EQ(Parse("camera.tangential.1").values, (Values{1, 0, 1, 0}));
}

TEST(Direction, ObjectsMayHaveDotsInTheirNames) {
  renderer::Scene scene = TestScene();
  scene.sensors[0].name = "IMG_1.x.jpg";
  EXPECT_EQ(ParseDirection(scene, "IMG_1.x.jpg.position.z").values, (Values{0, 0, 1}));
  EXPECT_EQ(ParseDirection(scene, "IMG_1.x.jpg.focal").values, (Values{1, 1}));
}

TEST(Direction, WhatIsWrongIsSaid) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"tri", "expected OBJECT.PROPERTY, for example axe.vertices.x"},
      {"tri.vertexes",
       "nothing in the scene is called 'tri.vertexes' (did you mean 'tri.vertices'?)"},
      {"tir.vertices", "no mesh is called 'tir' (did you mean 'tri'?)"},
      {"tri.vertices[3]", "the index must be below 3"},
      {"tri.vertices[a]", "expected a whole number in the brackets"},
      {"tri.vertices.r", "the component must be one of x, y, z"},
      {"tri.scale.x", "this property is a single number, without components"},
      {"tri.translation", "a component is needed behind it: one of x, y, z"},
      {"lamp.normals", "'lamp.normals' needs a mesh with normals"},
      {"lamp.position.x", "'lamp.position' needs a light of type point, spot or projector"},
      {"frost.metallic", "'frost.metallic' needs a material of model metallic_roughness"},
      {"spot.position.x",
       "'spot.position' could be that of a light or of a sensor; give them different names"}};
  for (const auto& [name, expected] : cases) {
    EXPECT_EQ(ErrorOf(name), "parameter '" + name + "': " + expected);
  }
}

TEST(Direction, OneTextureCoordinateNeedsNoComponent) {
  renderer::Scene scene = TestScene();
  scene.meshes[0].mesh.uvs.resize(1);
  EXPECT_EQ(ParseDirection(scene, "tri.uvs").values, (Values{1, 1}));
  EXPECT_EQ(ParseDirection(scene, "tri.uvs.v").values, (Values{0, 1}));
  EXPECT_EQ(DirectionNames(scene, "tri.uvs"), (std::vector<std::string>{"tri.uvs"}));
}

TEST(Direction, UnknownsAreMovedByAllTheirComponents) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(DirectionNames(TestScene(), "tri.rotation"),
            (Names{"tri.rotation.x", "tri.rotation.y", "tri.rotation.z"}));
  EXPECT_EQ(DirectionNames(TestScene(), "tri.rotation.y"), (Names{"tri.rotation.y"}));
  EXPECT_EQ(DirectionNames(TestScene(), "gold.base_color"), (Names{"gold.base_color"}));
  EXPECT_EQ(DirectionNames(TestScene(), "exposure"), (Names{"exposure"}));
}

}  // namespace
}  // namespace pathfit::app::direction_test
