// The scene of a config: shapes, materials, textures, lights, sensors and what may be unknown of
// them.
#include <array>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/app/config/config_text.h"

namespace pathfit::app::scene_config_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

template <class List>
const auto& Named(const List& list, const std::string& name) {
  for (const auto& item : list) {
    if (item.name == name) return item;
  }
  throw std::logic_error("nothing is called " + name);
}

TEST(SceneConfig, ReadsShapes) {
  const ConfigFile file(kRichConfig);
  const ExperimentConfig config = LoadExperimentConfig(file.path(), {});
  EXPECT_EQ(std::get<DiskGeometry>(Named(config.geometry, "pane").geometry).segments, 12);
  const GeometryConfig& room = Named(config.geometry, "room");
  EXPECT_EQ(std::get<FileGeometry>(room.geometry).path, file.folder() / "room.obj");
  using Group = std::pair<std::string, std::string>;
  EXPECT_EQ(room.group_materials,
            (std::vector<Group>{{"oak.001", "wood"}, {"brass lamp", "brass"}}));
  EXPECT_EQ(room.normals, GeometryConfig::Normals::kFlat);
  EXPECT_TRUE(room.repair);
  const auto& tri = std::get<InlineGeometry>(Named(config.geometry, "tri").geometry);
  EXPECT_EQ(tri.normals[2], (Triple{1, 0, 1}));
  EXPECT_EQ(tri.uvs[1], (std::array<double, 2>{1, 0}));
  EXPECT_EQ(Named(config.geometry, "bulb").normals, GeometryConfig::Normals::kSmooth);
  EXPECT_EQ(Named(config.geometry, "floor").normals, GeometryConfig::Normals::kDefault);
}

TEST(SceneConfig, ReadsMaterialsAndTextures) {
  using Model = MaterialConfig::Model;
  const ExperimentConfig config = LoadText(kRichConfig);
  const MaterialConfig& wood = Named(config.materials, "wood");
  EXPECT_EQ(wood.base_color_source, MaterialConfig::BaseColor::kTexture);
  EXPECT_EQ(wood.base_color_texture, "oak");
  EXPECT_EQ(wood.roughness_texture, "worn");
  EXPECT_DOUBLE_EQ(wood.gltf.metallic, 0.1);
  EXPECT_DOUBLE_EQ(wood.gltf.specular, 1.0);
  const MaterialConfig& brass = Named(config.materials, "brass");
  EXPECT_EQ(brass.model, Model::kConductor);
  EXPECT_EQ(brass.metal, "copper");
  EXPECT_EQ(brass.base_color, (Triple{1, 1, 1})) << "a factor";
  EXPECT_EQ(Named(config.materials, "alloy").k, (Triple{4, 5, 6}));
  EXPECT_EQ(Named(config.materials, "plain").model, Model::kMirror);
  EXPECT_DOUBLE_EQ(Named(config.materials, "frost").ior, 1.33);
  EXPECT_DOUBLE_EQ(Named(config.materials, "clear").ior, 1.5);
  EXPECT_EQ(Named(config.textures, "oak").role, TextureConfig::Role::kBaseColor)
      << "though a light uses it, too";
  EXPECT_FALSE(Named(config.textures, "oak").repeat);
  EXPECT_EQ(Named(config.textures, "worn").role, TextureConfig::Role::kRoughness);
  EXPECT_EQ(Named(config.textures, "worn").init, (Triple{0.4, 0.4, 0.4}));
  EXPECT_EQ(Named(config.textures, "slide").role, TextureConfig::Role::kLight);
}

TEST(SceneConfig, ReadsLights) {
  using Type = LightConfig::Type;
  const ExperimentConfig config = LoadText(kRichConfig);
  const LightConfig& lamp = Named(config.lights, "lamp");
  EXPECT_EQ(lamp.type, Type::kSpot);
  EXPECT_EQ(lamp.direction, (Triple{0, -2, 0})) << "towards the target";
  EXPECT_NEAR(lamp.outer_angle, 40 * kDegree, 1e-15);
  EXPECT_NEAR(lamp.inner_angle, 30 * kDegree, 1e-15);
  const LightConfig& torch = Named(config.lights, "torch");
  EXPECT_EQ(torch.direction, (Triple{0, 0, -2}));
  EXPECT_NEAR(torch.inner_angle, 5 * kDegree, 1e-15);
  EXPECT_TRUE(torch.camera_frame);
  const LightConfig& beamer = Named(config.lights, "beamer");
  EXPECT_EQ(beamer.type, Type::kProjector);
  EXPECT_EQ(beamer.texture, "slide");
  EXPECT_NEAR(beamer.fov, 30 * kDegree, 1e-15);
  EXPECT_EQ(beamer.fov_axis, FovAxis::kX);
  EXPECT_EQ(beamer.up, (Triple{0, 1, 0}));
  EXPECT_NEAR(beamer.angle, std::numbers::pi, 1e-15);
  const LightConfig& glow = Named(config.lights, "glow");
  EXPECT_EQ(glow.type, Type::kArea);
  EXPECT_EQ(glow.mesh, "bulb");
  EXPECT_EQ(glow.intensity, (Triple{3, 3, 3}));
  EXPECT_TRUE(glow.two_sided);
}

TEST(SceneConfig, ReadsSensorsAndBudgets) {
  const ExperimentConfig config = LoadText(kRichConfig);
  const SensorConfig& front = Named(config.sensors, "front");
  EXPECT_EQ(front.filter.shape, renderer::PixelFilter::Shape::kGaussian);
  EXPECT_DOUBLE_EQ(front.filter.radius, 2.0);
  EXPECT_DOUBLE_EQ(front.filter.sigma, 0.6);
  const SensorConfig& plan = Named(config.sensors, "plan");
  EXPECT_EQ(plan.projection, renderer::ProjectionKind::kOrthographic);
  EXPECT_EQ(plan.focal_px, (std::array<double, 2>{4, 4})) << "20 px for 5 m";
  EXPECT_EQ(plan.filter.shape, renderer::PixelFilter::Shape::kTent);
  EXPECT_DOUBLE_EQ(plan.filter.radius, 1.0);
  const renderer::RenderOptions& render = config.render;
  EXPECT_DOUBLE_EQ(render.spp_direct, 2.0);
  EXPECT_DOUBLE_EQ(render.spp_indirect, 3.0);
  EXPECT_DOUBLE_EQ(render.spp_pixel, 0.0);
  EXPECT_EQ(render.terms,
            (renderer::DerivativeTerms{renderer::DerivativeTerm::kInterior,
                                       renderer::DerivativeTerm::kDirect}));
  EXPECT_EQ(render.form, renderer::DerivativeForm::kMaterial);
  EXPECT_EQ(render.guide, renderer::GuideKind::kGrid);
  EXPECT_DOUBLE_EQ(render.guide_share, 0.5);
}

using Cases = std::vector<std::pair<std::string, std::string>>;

void ExpectProblems(const Cases& cases) {
  for (const auto& [assignment, expected] : cases) {
    EXPECT_EQ(ProblemOf(kRichConfig, {assignment}), "--set #1: " + expected) << assignment;
  }
}

TEST(SceneMistakes, MaterialsAndTexturesAreChecked) {
  ExpectProblems(
      {{"scene.materials.alloy={model: conductor}",
        "scene.materials.alloy: one of the keys metal, eta is needed"},
       {"scene.materials.brass.eta=[1, 1, 1]",
        "scene.materials.brass: key 'eta' needs key 'k'\n"
        "--set #1: scene.materials.brass: 'eta' and 'metal' cannot be given together"},
       {"scene.materials.frost.ior=1",
        "scene.materials.frost.ior: an ior of 1 is no surface; take the mesh out of the scene "
        "instead"},
       {"scene.materials.frost.two_sided=true",
        "scene.materials.frost: key 'two_sided' does not belong to model 'dielectric', only to "
        "diffuse, metallic_roughness, conductor, mirror"},
       {"scene.materials.wall={model: diffuse}",
        "scene.materials.wall: required key 'base_color' is missing (a map)"},
       {"scene.materials.brass.metal=golt",
        "scene.materials.brass.metal: 'golt' is not allowed; one of aluminium, chromium, copper, "
        "gold, iron, nickel, platinum, silver, titanium, tungsten is needed (did you mean "
        "'gold'?)"},
       {"scene.materials.wall.base_color={texture: oka}",
        "scene.materials.wall.base_color.texture: no texture is called 'oka' (did you mean "
        "'oak'?)"},
       {"scene.materials.wall.base_color={texture: worn}",
        "scene.materials.wall.base_color.texture: texture 'worn' is used as roughness or metallic "
        "already, so it cannot be a colour; name its file twice"},
       {"scene.materials.wood.normal={texture: oak}",
        "scene.materials.wood.normal.texture: texture 'oak' is used as a colour already, so it "
        "cannot be normals; name its file twice"},
       {"scene.textures.worn.init.constant=0.02",
        "scene.textures.worn.init.constant: 0.02 is out of range (allowed for roughness: from 0.03 "
        "to 1)"},
       {"scene.textures.worn.init.constant=[0.3, 0.4, 0.5]",
        "scene.textures.worn.init.constant: roughness and metallic are one number, not a colour"},
       {"scene.textures.worn.file=a.png",
        "scene.textures.worn: 'file' and 'size_px' cannot be given together"},
       {"scene.textures.oak.role=data",
        "scene.textures.oak.role: key 'role' is not supported; what uses the texture decides"}});
}

TEST(SceneMistakes, LightsAreChecked) {
  ExpectProblems(
      {{"scene.lights.lamp.inner_deg=40",
        "scene.lights.lamp.inner_deg: inner_deg 40 must be below outer_deg 40"},
       {"scene.lights.lamp.direction=[0, 0, 1]",
        "scene.lights.lamp: 'direction' and 'target_m' cannot be given together"},
       {"scene.lights.lamp.target_m=[0, 2, 0]",
        "scene.lights.lamp.target_m: the target is where the light stands"},
       {"scene.lights.torch={type: spot, position_m: [0, 0, 0], outer_deg: 9}",
        "scene.lights.torch: one of the keys target_m, direction is needed"},
       {"scene.lights.torch={type: spot, position_m: [0, 0, 0], direction: 5, outer_deg: 9}",
        "scene.lights.torch.direction: a list of 3 numbers is needed, not '5'"},
       {"scene.lights.beamer.up=[0, 0, 1]",
        "scene.lights.beamer.up: up must not be zero or along the direction of the light"},
       {"scene.lights.lamp.intensity=[1e30, 1, 1]",
        "scene.lights.lamp.intensity[0]: 1e30 is out of range (allowed: a number from 0 to 1e+20)"},
       {"scene.lights.sky={type: envmap, size_px: [4, 2], init: {constant: [1, 1, 1e30]}}",
        "scene.lights.sky.init.constant[2]: 1e30 is out of range (allowed: a number from 0 to "
        "1e+20)"},
       {"scene.lights.glow.mesh=blub",
        "scene.lights.glow.mesh: no mesh is called 'blub' (did you mean 'bulb'?)"},
       {"scene.lights.glow.frame=camera",
        "scene.lights.glow: key 'frame' does not belong to type 'area', only to envmap, constant, "
        "point, directional, spot, projector"}});
}

TEST(SceneConfig, TrianglesWithoutAreaMayBeRepaired) {
  const std::string flat = "scene.geometry.tri.mesh.triangles[0]=[0, 1, 1]";
  EXPECT_TRUE(Named(LoadText(kRichConfig, {flat, "scene.geometry.tri.repair=true"}).geometry, "tri")
                  .repair);
}

TEST(SceneMistakes, GeometryAndSensorsAreChecked) {
  ExpectProblems(
      {{"scene.geometry.room.materials={oak.001: woood}",
        "scene.geometry.room.materials.oak.001: no material is called 'woood' (did you mean "
        "'wood'?)"},
       {"scene.geometry.bulb.materials={a: wood}",
        "scene.geometry.bulb: key 'materials' needs key 'file'"},
       {"scene.geometry.tri.mesh.uvs=[[0, 0]]",
        "scene.geometry.tri.mesh.uvs: 1 UVs for 3 vertices; one for each is needed"},
       {"scene.geometry.tri.mesh.triangles[0]=[0, 1, 1]",
        "scene.geometry.tri.mesh.triangles: the triangle has no area"},
       {"scene.geometry.bulb.transform={scale: 1e30}",
        "scene.geometry.bulb.transform.scale: 1e30 is out of range (allowed: a number between 0 "
        "and 1000000000000, or a list of 3 numbers between 0 and 1000000000000)"},
       {"scene.geometry.bulb.transform={translate_m: [0, -1e300, 0]}",
        "scene.geometry.bulb.transform.translate_m[1]: -1e300 is out of range (allowed: a number "
        "from -1000000000000 to 1000000000000)"},
       {"scene.geometry.tri.mesh.normals[1]=[0, 0, 0]",
        "scene.geometry.tri.mesh.normals: a normal must not be [0, 0, 0]"},
       {"scene.sensors.plan.fov_deg=30",
        "scene.sensors.plan: key 'fov_deg' does not belong to type 'orthographic', only to "
        "perspective"},
       {"scene.sensors.front.filter={type: box, radius_px: 2}",
        "scene.sensors.front.filter: key 'radius_px' does not belong to type 'box', only to tent, "
        "gaussian"},
       {"scene.sensors.front.filter=sinc",
        "scene.sensors.front.filter: 'sinc' is not allowed; one of box, tent, gaussian, or a map "
        "is needed"},
       {"render.terms=[interior, shadow]",
        "render.terms[1]: 'shadow' is not allowed; one of interior, primary, direct, indirect, "
        "pixel is needed"},
       {"render.terms=[interior, interior]", "render.terms: 'interior' is given twice"},
       {"render.terms=[]",
        "render.terms: a list of words (at least 1) out of interior, primary, direct, "
        "indirect, pixel is needed, not 0 items"}});
}

TEST(SceneMistakes, AMeshShinesOnce) {
  EXPECT_EQ(ProblemOf(kRichConfig, {"scene.lights.sky={type: area, mesh: bulb}"}),
            "33:30: scene.lights.glow.mesh: mesh 'bulb' has an area light already");
}

}  // namespace
}  // namespace pathfit::app::scene_config_test
