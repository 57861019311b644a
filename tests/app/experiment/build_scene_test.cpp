#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "app/experiment/experiment.h"
#include "renderer/bsdf/metals.h"
#include "renderer/core/error.h"
#include "renderer/image/image.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/image_file.h"
#include "tests/app/config/config_text.h"

namespace pathfit::app::build_scene_test {
namespace {

namespace fs = std::filesystem;
using renderer::Rgb;
using renderer::Vec3;

constexpr double kRounding = 1e-12;

Experiment Build(const std::string& text) {
  const ConfigFile file(text);
  return BuildExperiment(LoadExperimentConfig(file.path(), {}));
}

/// A scene of the given parts, one per line without indentation, seen by a small camera.
std::string SceneOf(const std::string& geometry,
                    const std::string& materials,
                    const std::string& more = "") {
  return "schema: 1\nscene:\n  geometry: {" + geometry + "}\n  materials: {" + materials + "}\n" +
         more +
         "  sensors: {eye: {size_px: [8, 8], focal_px: 8, pose: {look_at: {origin_m: [0, 0, 5], "
         "target_m: [0, 0, 0]}}}}\n";
}

const char* const kGrey = "grey: {model: diffuse, base_color: {constant: [0.5, 0.5, 0.5]}}";

template <class List>
const auto& Named(const List& list, const std::string& name) {
  for (const auto& item : list) {
    if (item.name == name) return item;
  }
  throw std::logic_error("nothing is called " + name);
}

void ExpectNear(const Vec3& a, const Vec3& b, double tolerance = kRounding) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(BuildScene, BuildsEveryTestScene) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(PATHFIT_SOURCE_DIR) / "tests/scenes")) {
    if (entry.path().extension() != ".yaml") continue;
    ++count;
    ExperimentConfig config = LoadExperimentConfig(entry.path(), {});
    for (GeometryConfig& geometry : config.geometry) {
      auto* sphere = std::get_if<SphereGeometry>(&geometry.geometry);
      if (sphere != nullptr) sphere->subdivisions = 1;  // for speed
    }
    EXPECT_NO_THROW(BuildExperiment(config)) << entry.path();
  }
  EXPECT_GE(count, 20);
}

TEST(BuildScene, BuildsEveryModel) {
  const Experiment experiment = Build(SceneOf(
      "a: {primitive: {cube: {}}, material: gold}",
      "gold: {model: conductor, metal: gold, roughness: {constant: 0.2}, distribution: beckmann}, "
      "own: {model: conductor, eta: [1, 2, 3], k: [4, 5, 6]}, "
      "plain: {model: mirror}, glass: {model: glass, ior: 1.4}, "
      "milky: {model: dielectric, distribution: beckmann}, "
      "frost: {model: dielectric, roughness: {constant: 0.3}, base_color: {constant: [1, 0, 0]}}"));
  const auto& materials = experiment.scene.materials;
  const auto& gold = std::get<renderer::RoughConductorBsdf>(Named(materials, "gold").bsdf);
  EXPECT_EQ(gold.eta, renderer::NamedMetal("gold")->eta);
  EXPECT_EQ(gold.k, renderer::NamedMetal("gold")->k);
  EXPECT_DOUBLE_EQ(gold.roughness, 0.2);
  EXPECT_EQ(Named(materials, "gold").base_color, Rgb::Constant(1.0)) << "a factor";
  const auto& own = std::get<renderer::RoughConductorBsdf>(Named(materials, "own").bsdf);
  EXPECT_EQ(own.k, (Rgb{4, 5, 6}));
  EXPECT_EQ(gold.distribution, renderer::MicrofacetDistribution::kBeckmann);
  EXPECT_EQ(own.distribution, renderer::MicrofacetDistribution::kGgx);
  EXPECT_EQ(std::get<renderer::RoughDielectricBsdf>(Named(materials, "milky").bsdf).distribution,
            renderer::MicrofacetDistribution::kBeckmann);
  EXPECT_EQ(std::get<renderer::MirrorBsdf>(Named(materials, "plain").bsdf), renderer::MirrorBsdf{});
  EXPECT_DOUBLE_EQ(std::get<renderer::SmoothDielectricBsdf>(Named(materials, "glass").bsdf).eta,
                   1.4);
  const auto& frost = std::get<renderer::RoughDielectricBsdf>(Named(materials, "frost").bsdf);
  EXPECT_DOUBLE_EQ(frost.roughness, 0.3);
  EXPECT_EQ(Named(materials, "frost").base_color, (Rgb{1, 0, 0}));
}

TEST(BuildScene, NormalsAreFlatSmoothOrGiven) {
  const std::string mesh =
      "mesh: {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 2]], "
      "normals: [[0, 0, 2], [1, 0, 1], [0, 1, 1]]}, material: grey";
  const Experiment experiment =
      Build(SceneOf("given: {" + mesh + "}, flat: {" + mesh + ", normals: flat}, smooth: {" + mesh +
                        ", normals: smooth}, ball: {primitive: {sphere: {subdivisions: 1}}, "
                        "material: grey, normals: smooth, transform: {scale: [2, 1, 1]}}",
                    kGrey));
  const auto& meshes = experiment.scene.meshes;
  EXPECT_TRUE(Named(meshes, "flat").mesh.normals.empty());
  ASSERT_EQ(Named(meshes, "given").mesh.normals.size(), 3U);
  ExpectNear(Named(meshes, "given").mesh.normals[1], {std::sqrt(0.5), 0.0, std::sqrt(0.5)});
  ExpectNear(Named(meshes, "smooth").mesh.normals[1], {0, 0, 1});
  // Of an ellipsoid, whose normal at (x, y, z) is along (x / 4, y, z).
  const renderer::Mesh& ball = Named(meshes, "ball").mesh;
  ASSERT_EQ(ball.normals.size(), ball.positions.size());
  for (std::size_t i = 0; i < ball.positions.size(); ++i) {
    const Vec3& p = ball.positions[i];
    const Vec3 expected = Normalized(Vec3{p.x / 4, p.y, p.z});
    EXPECT_GT(Dot(Normalized(ball.normals[i]), expected), 0.999);
  }
}

TEST(BuildScene, AMeshOfUnknownVerticesIsFlatUnlessToldOtherwise) {
  const std::string mesh =
      "mesh: {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 2]], "
      "normals: [[0, 0, 2], [1, 0, 1], [0, 1, 1]]}, material: grey";
  const Experiment experiment =
      Build(SceneOf("moved: {" + mesh + "}, kept: {" + mesh + ", normals: file}, held: {" + mesh +
                        "}, both: {" + mesh + "}",
                    kGrey) +
            "unknowns:\n  moved.vertices: {}\n  kept.vertices: {}\n  held.vertices: {hold: true}\n"
            "  both.vertices: {}\n  both.normals: {}\n");
  const auto& meshes = experiment.scene.meshes;
  EXPECT_TRUE(Named(meshes, "moved").mesh.normals.empty());
  EXPECT_EQ(Named(meshes, "kept").mesh.normals.size(), 3U);
  EXPECT_EQ(Named(meshes, "held").mesh.normals.size(), 3U);
  EXPECT_EQ(Named(meshes, "both").mesh.normals.size(), 3U);
  ASSERT_GE(experiment.assumptions.size(), 2U);
  EXPECT_NE(experiment.assumptions[0].find("Mesh moved is shaded flat"), std::string::npos);
  EXPECT_NE(experiment.assumptions[1].find("normals of kept stay"), std::string::npos);
}

TEST(BuildFitSpec, CamerasHaveAPriorAroundTheirStart) {
  const Experiment experiment =
      Build(SceneOf("ball: {primitive: {sphere: {}}, material: grey}", kGrey) +
            "unknowns:\n  camera.position: {}\n  eye.focal: {}\n  ball.translation: {}\n"
            "  eye.rotation: {priors: [{gaussian: {mean: start, sigma: 0.5}}]}\n");
  const auto& unknowns = experiment.fit.unknowns;
  EXPECT_EQ(unknowns[0].object, -1);
  ASSERT_TRUE(unknowns[0].gaussian);
  EXPECT_TRUE(unknowns[0].gaussian->mean.empty());
  EXPECT_NEAR(unknowns[0].gaussian->sigma, 0.02 * 5.0, 1e-12);
  EXPECT_EQ(unknowns[1].object, 0);
  EXPECT_NEAR(unknowns[1].gaussian->sigma, 0.02 * 8.0, 1e-12);
  EXPECT_EQ(unknowns[1].lower, 1.0);
  EXPECT_FALSE(unknowns[2].gaussian);
  EXPECT_EQ(unknowns[3].gaussian->sigma, 0.5);
}

TEST(BuildFitSpec, StagesTakeTheirBudgetsAndTheTermsOfRender) {
  const ExperimentConfig config = LoadText(kFitConfig,
                                           {"stages.all.spp_direct=3",
                                            "stages.all.spp_indirect=0.5",
                                            "stages.all.spp_pixel=7",
                                            "render.form=material",
                                            "render.terms=[interior, direct]",
                                            "render.guiding=grid",
                                            "render.guide_share=0.1"});
  EXPECT_FALSE(config.fit.stages[0].samples.spp_direct);  // to be found
  renderer::Scene scene;
  scene.meshes = {{"mug", {}, 0}, {"disc", {}, 1}};
  scene.materials = {{"glaze", renderer::MetallicRoughnessBsdf{}}, {"paint", {}}};
  scene.materials[0].vertex_colors = true;
  scene.meshes[0].mesh.positions = {{}};
  scene.meshes[0].mesh.colors = {{}};
  renderer::EnvironmentEmitter room;
  room.texels.resize(2);
  scene.emitters = {{"room", {}, {}, room}, {"lamp", {}, {}, renderer::PointEmitter{}}};
  const optim::FitSpec fit = BuildFitSpec(config, scene);
  EXPECT_EQ(fit.stages[1].samples.spp_direct, 3.0);
  EXPECT_EQ(fit.stages[1].samples.spp_indirect, 0.5);
  EXPECT_EQ(fit.stages[1].samples.spp_pixel, 7.0);
  EXPECT_EQ(fit.estimators.form, renderer::DerivativeForm::kMaterial);
  EXPECT_EQ(fit.estimators.terms,
            (renderer::DerivativeTerms{renderer::DerivativeTerm::kInterior,
                                       renderer::DerivativeTerm::kDirect}));
  EXPECT_EQ(fit.estimators.guide, renderer::GuideKind::kGrid);
  EXPECT_EQ(fit.estimators.guide_share, 0.1);
}

TEST(BuildScene, PosesTurnAboutTheMiddleUnlessTold) {
  const Experiment experiment = Build(
      SceneOf("a: {primitive: {cube: {}}, material: grey, transform: {translate_m: [1, 2, 3]}}, "
              "b: {primitive: {cube: {}}, material: grey, pivot_m: [0, 1, 0]}",
              kGrey));
  EXPECT_EQ(Named(experiment.scene.meshes, "a").pose.pivot, (Vec3{1, 2, 3}));
  EXPECT_EQ(Named(experiment.scene.meshes, "b").pose.pivot, (Vec3{0, 1, 0}));
  EXPECT_EQ(Named(experiment.scene.meshes, "a").pose.translation, Vec3{});
}

TEST(BuildScene, TexturesAreReadByTheirUse) {
  const ConfigFile file("");
  renderer::Image picture(2, 1, 3);
  picture.data = {0.5F, 0.25F, 0.75F, 1.0F, 1.0F, 1.0F};
  renderer::WritePng8(file.folder() / "p.png", picture);
  file.Write(SceneOf("a: {primitive: {cube: {}}, material: paint}",
                     "paint: {model: metallic_roughness, base_color: {texture: colour}, roughness: "
                     "{texture: worn}, specular: 0.3}",
                     "  textures: {colour: {file: p.png, wrap: clamp}, worn: {file: p.png}, spare: "
                     "{size_px: [3, 2], init: {constant: [1, 2, 3]}}}\n"));
  const Experiment experiment = BuildExperiment(LoadExperimentConfig(file.path(), {}));
  const renderer::Scene& scene = experiment.scene;
  ASSERT_EQ(scene.textures.size(), 3U);
  const double code = 128.0 / 255.0;
  EXPECT_NEAR(scene.textures[0].texels[0].r, std::pow((code + 0.055) / 1.055, 2.4), 1e-6);
  EXPECT_EQ(scene.textures[0].wrap, renderer::TextureWrap::kClamp);
  EXPECT_FALSE(scene.textures[0].scalar);
  EXPECT_NEAR(scene.textures[1].texels[0].g, code, 1e-6) << "the red channel as it is";
  EXPECT_TRUE(scene.textures[1].scalar);
  EXPECT_EQ(scene.textures[2].texels, std::vector<Rgb>(6, Rgb{1, 2, 3}));
  EXPECT_EQ(scene.materials[0].base_color_texture, 0);
  EXPECT_EQ(scene.materials[0].roughness_texture, 1);
  EXPECT_EQ(scene.materials[0].metallic_texture, -1);
  EXPECT_EQ(std::get<renderer::MetallicRoughnessBsdf>(scene.materials[0].bsdf).specular, 0.3);
  EXPECT_EQ(experiment.input_files.size(), 2U);
}

TEST(BuildScene, NormalTexturesAreReadAsTheyAre) {
  const ConfigFile file("");
  renderer::Image picture(2, 1, 3);
  picture.data = {0.5F, 0.25F, 1.0F, 0.5F, 0.5F, 1.0F};
  renderer::WritePng8(file.folder() / "p.png", picture);
  const std::string textures = "  textures: {bumps: {file: p.png}}\n";
  const std::string paint =
      "paint: {model: metallic_roughness, base_color: {constant: [1, 1, 1]}, normal: {texture: "
      "bumps, scale: 0.5}}";
  file.Write(SceneOf(
      "a: {primitive: {rectangle: {}}, material: paint, normals: smooth}", paint, textures));
  const Experiment experiment = BuildExperiment(LoadExperimentConfig(file.path(), {}));
  const renderer::Scene& scene = experiment.scene;
  EXPECT_EQ(scene.materials.at(0).normal_texture, 0);
  EXPECT_EQ(scene.materials[0].normal_scale, 0.5);
  EXPECT_NEAR(scene.textures.at(0).texels[0].g, 64.0 / 255.0, 1e-6);
  EXPECT_NO_THROW(renderer::ValidateScene(scene));
}

TEST(BuildScene, LightsPointWhereTheyAreAimed) {
  const Experiment experiment = Build(SceneOf(
      "lamp: {primitive: {rectangle: {}}, material: grey}",
      kGrey,
      "  textures: {slide: {size_px: [4, 2]}}\n"
      "  lights:\n"
      "    down: {type: spot, position_m: [1, 2, 3], direction: [0, -3, 0], outer_deg: 20}\n"
      "    turned: {type: spot, position_m: [0, 0, 0], target_m: [0, 0, -1], outer_deg: 20, "
      "rotate: {axis: [0, 1, 0], angle_deg: 90}}\n"
      "    sun: {type: directional, direction: [2, 0, 0], rotate: {axis: [0, 0, 1], angle_deg: "
      "90}}\n"
      "    beamer: {type: projector, position_m: [0, 0, 3], target_m: [0, 0, 0], fov_deg: 90, "
      "fov_axis: x, texture: slide}\n"
      "    glow: {type: area, mesh: lamp, radiance: [1, 2, 3], texture: slide, two_sided: "
      "true}\n"));
  const auto& lights = experiment.scene.emitters;
  const Vec3 forward{0, 0, -1};
  const auto& down = std::get<renderer::SpotEmitter>(Named(lights, "down").light);
  ExpectNear(down.frame_from_light * forward, {0, -1, 0});
  EXPECT_EQ(down.position, (Vec3{1, 2, 3}));
  EXPECT_NEAR(down.outer_angle, std::numbers::pi / 9.0, kRounding);
  const auto& turned = std::get<renderer::SpotEmitter>(Named(lights, "turned").light);
  ExpectNear(turned.frame_from_light * forward, {-1, 0, 0});
  EXPECT_EQ(Named(lights, "turned").rotation, Vec3{}) << "the parameter starts at zero";
  const auto& sun = std::get<renderer::DirectionalEmitter>(Named(lights, "sun").light);
  ExpectNear(sun.direction, {0, 1, 0});
  const auto& beamer = std::get<renderer::ProjectorEmitter>(Named(lights, "beamer").light);
  EXPECT_NEAR(beamer.tan_half_width, 1.0, kRounding);
  EXPECT_NEAR(beamer.tan_half_height, 0.5, kRounding);
  ExpectNear(beamer.frame_from_light * Vec3{1, 0, 0}, {1, 0, 0});
  ExpectNear(beamer.frame_from_light * Vec3{0, 1, 0}, {0, 1, 0});
  EXPECT_EQ(beamer.texture, 0);
  const auto& glow = std::get<renderer::AreaEmitter>(Named(lights, "glow").light);
  EXPECT_EQ(glow.mesh, 0);
  EXPECT_EQ(glow.intensity, (Rgb{1, 2, 3}));
  EXPECT_TRUE(glow.two_sided);
}

TEST(BuildScene, SensorsHaveFiltersAndParallelRays) {
  const Experiment experiment = Build(
      "schema: 1\nscene:\n  geometry: {a: {primitive: {cube: {}}, material: grey}}\n  materials: "
      "{" +
      std::string(kGrey) +
      "}\n  sensors:\n"
      "    plan: {type: orthographic, size_px: [40, 20], height_m: 5, filter: tent, crop_px: [10, "
      "0, 10, 20], pose: {look_at: {origin_m: [0, 0, 9], target_m: [0, 0, 0]}}}\n"
      "    soft: {size_px: [8, 8], focal_px: 8, filter: {type: gaussian, radius_px: 1.5}, pose: "
      "{look_at: {origin_m: [0, 0, 9], target_m: [0, 0, 0]}}}\n");
  const renderer::Camera& plan = experiment.scene.sensors[0];
  EXPECT_EQ(plan.projection, renderer::ProjectionKind::kOrthographic);
  EXPECT_DOUBLE_EQ(plan.fy, 4.0);
  EXPECT_DOUBLE_EQ(plan.cx, 10.0);
  EXPECT_EQ(plan.filter, (renderer::PixelFilter{renderer::PixelFilter::Shape::kTent, 1.0}));
  // The middle of the whole picture, at the left border of the part.
  const auto seen = renderer::CameraModel(plan).Project({0, 0, 0});
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->u, 10.0, kRounding);
  const renderer::PixelFilter& soft = experiment.scene.sensors[1].filter;
  EXPECT_EQ(soft, (renderer::PixelFilter{renderer::PixelFilter::Shape::kGaussian, 1.5, 0.5}));
}

class ObjGroups : public testing::Test {
 protected:
  ObjGroups() : file_("") {
    std::ofstream(file_.folder() / "room.obj")
        << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 2\n"
           "usemtl oak.001\nf 1 2 3\nusemtl wall\nf 1 4 2\nusemtl lamp\nf 1 3 4\n";
  }
  Experiment Build(const std::string& keys) {
    file_.Write(SceneOf("room: {file: room.obj, material: grey, " + keys + "}",
                        std::string(kGrey) + ", wood: {model: mirror}"));
    return BuildExperiment(LoadExperimentConfig(file_.path(), {}));
  }
  ConfigFile file_;
};

TEST_F(ObjGroups, BecomeMeshesWithTheirMaterials) {
  const Experiment experiment = Build("materials: {oak.001: wood}");
  const auto& meshes = experiment.scene.meshes;
  ASSERT_EQ(meshes.size(), 2U);
  EXPECT_EQ(meshes[0].name, "room");
  EXPECT_EQ(meshes[0].mesh.triangles.size(), 2U) << "wall and lamp, welded along their edge";
  EXPECT_EQ(meshes[0].mesh.positions.size(), 4U);
  EXPECT_EQ(meshes[0].material, 0);
  EXPECT_EQ(meshes[1].name, "room-oak_001");
  EXPECT_EQ(meshes[1].mesh.triangles.size(), 1U);
  EXPECT_EQ(meshes[1].material, 1);
  EXPECT_EQ(meshes[0].pose.pivot, (Vec3{0.5, 0.5, 1.0}));
  EXPECT_EQ(meshes[1].pose.pivot, meshes[0].pose.pivot) << "they move together";
}

TEST_F(ObjGroups, ThatDoNotExistAreNamed) {
  try {
    Build("materials: {oak: wood}");
    FAIL();
  } catch (const renderer::SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("has no usemtl 'oak' (known: oak.001, wall, lamp)"),
              std::string::npos)
        << error.what();
  }
}

TEST_F(ObjGroups, AFileWithAMeshThatCannotBeUsedIsNamed) {
  std::ofstream(file_.folder() / "room.obj") << "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n";
  try {
    Build("repair: false");
    FAIL();
  } catch (const renderer::SceneError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("room.obj: mesh 'room': triangle 0 has zero area"), std::string::npos)
        << text;
    EXPECT_NE(text.find("`repair: true` mends"), std::string::npos) << text;
  }
}

/// Two triangles side by side with a material each, one of which shines, and a lamp.
class GltfScene : public testing::Test {
 protected:
  GltfScene() : file_("") {
    std::ofstream(file_.folder() / "room.gltf") << R"({"asset": {"version": "2.0"},
      "scenes": [{"nodes": [0, 1]}], "nodes": [{"name": "two walls", "mesh": 0},
        {"translation": [0, 0, 5], "camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}],
      "cameras": [{"type": "perspective", "name": "eye", "perspective":
        {"yfov": 1.5707963267948966, "znear": 0.1, "aspectRatio": 2}}],
      "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_basisu"],
      "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "name": "bulb"}]}},
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0},
                                 {"attributes": {"POSITION": 1}, "material": 1}]}],
      "materials": [{"name": "Oak.001", "pbrMetallicRoughness":
          {"baseColorFactor": [0.5, 0.25, 0.125, 1], "metallicFactor": 0}},
        {"name": "glow", "emissiveFactor": [1, 0, 0]}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": 3, "type": "VEC3"}],
      "bufferViews": [{"buffer": 0, "byteLength": 48}],
      "buffers": [{"uri": "room.bin", "byteLength": 48}]})";
    const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    std::ofstream(file_.folder() / "room.bin", std::ios::binary)
        .write(reinterpret_cast<const char*>(positions.data()), 48);
  }
  Experiment Build(const std::string& keys,
                   const std::string& more = "",
                   const std::string& rest = "") {
    file_.Write(SceneOf("room: {file: room.gltf" + keys + "}", kGrey, more) + rest);
    return BuildExperiment(LoadExperimentConfig(file_.path(), {}));
  }
  ConfigFile file_;
};

TEST_F(GltfScene, BringsItsMaterialsAndWhatShines) {
  const Experiment experiment =
      Build("", "", "unknowns: {Oak.001.base_color: {}, room-two_walls-Oak_001.vertices: {}}\n");
  const auto& scene = experiment.scene;
  ASSERT_EQ(scene.meshes.size(), 2U);
  EXPECT_EQ(scene.meshes[0].name, "room-two_walls-Oak_001");
  EXPECT_EQ(scene.meshes[1].name, "room-two_walls-glow");
  const auto& oak = scene.materials.at(static_cast<std::size_t>(scene.meshes[0].material));
  EXPECT_EQ(oak.name, "Oak.001");
  EXPECT_EQ(oak.base_color, (Rgb{0.5, 0.25, 0.125}));
  ASSERT_EQ(scene.emitters.size(), 1U);
  EXPECT_EQ(scene.emitters[0].name, "room-two_walls-glow-emission");
  EXPECT_EQ(std::get<renderer::AreaEmitter>(scene.emitters[0].light).mesh, 1);
  EXPECT_EQ(experiment.input_files.size(), 2U);
  ASSERT_EQ(experiment.warnings.size(), 1U);
  EXPECT_NE(experiment.warnings[0].find("KHR_texture_basisu"), std::string::npos);
  ASSERT_EQ(experiment.assumptions.size(), 2U);
  EXPECT_NE(
      experiment.assumptions[0].find("its lights are left out (1); `lights: true` takes them"),
      std::string::npos);
}

// A result that is read under the name it came from.
TEST_F(GltfScene, NamesThatItIsCalledByAlreadyStay) {
  std::string text = renderer::ReadWholeFile(file_.folder() / "room.gltf");
  text.replace(text.find("two walls"), 9, "room-walls");
  std::ofstream(file_.folder() / "room.gltf") << text;
  EXPECT_EQ(Build("").scene.meshes[0].name, "room-walls-Oak_001");
}

TEST_F(GltfScene, GetsOtherMaterialsByNameOrAltogether) {
  const Experiment one = Build(", materials: {glow: grey}");
  EXPECT_EQ(one.scene.meshes[1].material, 0);
  EXPECT_EQ(Named(one.scene.materials, "Oak.001").base_color, (Rgb{0.5, 0.25, 0.125}));
  EXPECT_TRUE(one.scene.emitters.empty()) << "the light was that of the material";
  const Experiment all = Build(", material: grey");
  EXPECT_EQ(all.scene.materials.size(), 1U);
  EXPECT_EQ(all.scene.meshes[0].material, 0);
  try {
    Build(", materials: {oak: grey}");
    FAIL();
  } catch (const renderer::SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("has no material 'oak' (known: "), std::string::npos);
  }
}

TEST_F(GltfScene, ItsLightsComeAlongIfWanted) {
  const std::string turned =
      ", lights: true, transform: {scale: 2, rotate: {axis: [0, 1, 0], angle_deg: 90}}";
  const auto scene = Build(turned).scene;
  const auto& bulb = Named(scene.emitters, "room-bulb");
  ExpectNear(std::get<renderer::PointEmitter>(bulb.light).position, {10, 0, 0}, 1e-9);
  EXPECT_THROW(Build(turned, "  lights: {room-bulb: {type: point, position_m: [0, 0, 1]}}\n"),
               renderer::SceneError);
}

TEST_F(GltfScene, ItsPartsMayBecomeLights) {
  const auto scene = Build(", material: grey",
                           "  lights: {lamp: {type: area, mesh: room-two_walls-glow, radiance: [1, "
                           "1, 1]}}\n")
                         .scene;
  EXPECT_EQ(std::get<renderer::AreaEmitter>(Named(scene.emitters, "lamp").light).mesh, 1);
  EXPECT_THROW(Build("", "  lights: {lamp: {type: area, mesh: room-x, radiance: [1, 1, 1]}}\n"),
               renderer::SceneError);
}

TEST_F(GltfScene, ItsCamerasComeAlongIfWanted) {
  const auto scene =
      Build(
          ", camera_height_px: 90, transform: {scale: 2, rotate: {axis: [0, 1, 0], angle_deg: "
          "90}}")
          .scene;
  const renderer::Camera& eye = Named(scene.sensors, "room-eye");
  EXPECT_EQ(eye.width, 180);
  EXPECT_EQ(eye.height, 90);
  EXPECT_NEAR(eye.fx, 45.0, 1e-9);
  EXPECT_NEAR(eye.fy, 45.0, 1e-9);
  EXPECT_EQ(eye.cx, 90.0);
  ExpectNear(eye.world_from_camera.translation, {10, 0, 0}, 1e-9);
  ExpectNear(eye.world_from_camera.linear.z, {1, 0, 0}, 1e-9);
  // Without any other.
  file_.Write("schema: 1\nscene: {geometry: {room: {file: room.gltf, camera_height_px: 9}}}\n");
  EXPECT_EQ(BuildExperiment(LoadExperimentConfig(file_.path(), {})).scene.sensors.size(), 1U);
}

TEST_F(GltfScene, TwoOfAFileHaveMaterialsOfTheirOwn) {
  file_.Write(SceneOf("a: {file: room.gltf}, b: {file: room.gltf}", kGrey));
  const auto scene = BuildExperiment(LoadExperimentConfig(file_.path(), {})).scene;
  EXPECT_EQ(scene.meshes.size(), 4U);
  EXPECT_EQ(Named(scene.materials, "b-Oak.001").base_color, (Rgb{0.5, 0.25, 0.125}));
}

TEST(BuildScene, SaysWhatWasRepaired) {
  const std::string twice =
      "mesh: {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], triangles: [[0, 1, 2], [1, "
      "2, 3], [0, 1, 2]]}, material: grey";
  EXPECT_THROW(Build(SceneOf("a: {" + twice + "}", kGrey)), renderer::SceneError);
  const Experiment experiment = Build(SceneOf("a: {" + twice + ", repair: true}", kGrey));
  EXPECT_EQ(experiment.scene.meshes[0].mesh.triangles.size(), 2U);
  ASSERT_EQ(experiment.assumptions.size(), 1U);
  EXPECT_EQ(experiment.assumptions[0].rfind("Mesh a was repaired: ", 0), 0U)
      << experiment.assumptions[0];
}

TEST(BuildScene, UnknownsFindTheirObjects) {
  const std::string text = SceneOf(
      "bulb: {primitive: {sphere: {}}, material: brass}",
      "brass: {model: conductor, metal: copper}",
      "  textures: {slide: {size_px: [4, 2]}}\n"
      "  lights: {lamp: {type: spot, position_m: [0, 2, 0], target_m: [0, 0, 0], outer_deg: 40}, "
      "beamer: {type: projector, position_m: [0, 0, 3], target_m: [0, 0, 0], fov_deg: 30, texture: "
      "slide}}\n");
  const Experiment experiment =
      Build(text +
            "unknowns: {bulb.rotation: {}, brass.eta: {}, brass.k: {}, slide.texels: {}, "
            "lamp.position: {}, beamer.rotation: {}, lamp.angles: {}, camera.focal: {}, "
            "eye.rotation: {}, exposure: {}}\n");
  using Kind = renderer::ParameterKind;
  const std::vector<std::pair<Kind, int>> expected = {{Kind::kObjectRotation, 0},
                                                      {Kind::kEta, 0},
                                                      {Kind::kExtinction, 0},
                                                      {Kind::kTextureTexels, 0},
                                                      {Kind::kLightPosition, 0},
                                                      {Kind::kLightRotation, 1},
                                                      {Kind::kSpotAngles, 0},
                                                      {Kind::kFocal, -1},
                                                      {Kind::kCameraRotation, 0},
                                                      {Kind::kExposure, -1}};
  ASSERT_EQ(experiment.fit.unknowns.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(experiment.fit.unknowns[i].kind, expected[i].first) << i;
    EXPECT_EQ(experiment.fit.unknowns[i].object, expected[i].second) << i;
  }
}

TEST(BuildScene, RenderOptionsFollowTheConfig) {
  ExperimentConfig config = LoadText(kRichConfig);
  const renderer::RenderOptions options = config.render;
  EXPECT_EQ(options.spp, 16);
  EXPECT_DOUBLE_EQ(options.spp_indirect, 3.0);
  EXPECT_EQ(options.form, renderer::DerivativeForm::kMaterial);
  EXPECT_EQ(options.guide, renderer::GuideKind::kGrid);
  EXPECT_EQ(options.terms,
            (renderer::DerivativeTerms{renderer::DerivativeTerm::kInterior,
                                       renderer::DerivativeTerm::kDirect}));
}

TEST(BuildScene, ARectangleLightIsABlackMeshThatShines) {
  const std::string turn = "rotate: {axis: [1, 0, 0], angle_deg: 120}";
  const Experiment rectangle = Build(SceneOf(
      "floor: {primitive: {rectangle: {}}, material: grey}",
      kGrey,
      "  lights: {lamp: {type: rectangle, position_m: [1, 2, 3], width_m: 4, height_m: 6, " + turn +
          ", radiance: [1, 2, 3], two_sided: true}}\n"));
  const Experiment spelled = Build(SceneOf(
      "floor: {primitive: {rectangle: {}}, material: grey}, lamp: {primitive: {rectangle: "
      "{}}, material: lamp, transform: {scale: [2, 3, 1], " +
          turn + ", translate_m: [1, 2, 3]}}",
      std::string(kGrey) + ", lamp: {model: diffuse, base_color: {constant: [0, 0, 0]}}",
      "  lights: {lamp: {type: area, mesh: lamp, radiance: [1, 2, 3], two_sided: true}}\n"));
  const auto& mesh = Named(rectangle.scene.meshes, "lamp");
  const auto& same = Named(spelled.scene.meshes, "lamp");
  EXPECT_EQ(mesh.mesh.positions, same.mesh.positions);
  EXPECT_EQ(mesh.material, same.material);
  EXPECT_EQ(Named(rectangle.scene.materials, "lamp").base_color, Rgb{});
  const auto& light =
      std::get<renderer::AreaEmitter>(Named(rectangle.scene.emitters, "lamp").light);
  EXPECT_EQ(light.mesh, 1);
  EXPECT_EQ(light.intensity, (Rgb{1, 2, 3}));
  EXPECT_TRUE(light.two_sided);
}

TEST(BuildScene, ARectangleLightNeedsANameOfItsOwn) {
  EXPECT_ANY_THROW(Build(SceneOf(
      "lamp: {primitive: {rectangle: {}}, material: grey}",
      kGrey,
      "  lights: {lamp: {type: rectangle, position_m: [1, 2, 3], width_m: 4, height_m: 6}}\n")));
}

}  // namespace
}  // namespace pathfit::app::build_scene_test
