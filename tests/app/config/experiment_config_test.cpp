#include "app/config/experiment_config.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "app/config/schema.h"
#include "tests/app/config/config_text.h"

namespace pathfit::app::experiment_config_test {
namespace {

const optim::UnknownSpec& UnknownOf(const ExperimentConfig& config, const std::string& name) {
  for (const optim::UnknownSpec& unknown : config.fit.unknowns) {
    if (unknown.name == name) return unknown;
  }
  throw std::logic_error("no unknown " + name);
}

TEST(ExperimentConfig, ReadsEveryPartOfAFit) {
  const ConfigFile file(kFitConfig);
  const ExperimentConfig config = LoadExperimentConfig(file.path(), {});
  EXPECT_EQ(config.path, file.path());
  EXPECT_EQ(config.given_text, kFitConfig);
  EXPECT_EQ(config.name, "mug");
  EXPECT_EQ(config.render.seed, 7U);
  ASSERT_TRUE(config.input);
  EXPECT_EQ(config.input->photos.images_dir, file.folder() / "photos");
  EXPECT_EQ(config.input->photos.cameras, file.folder() / "cameras/transforms.json");
  EXPECT_EQ(config.input->photos.camera_format, "transforms");
  EXPECT_EQ(config.input->photos.masks.meaning, optim::MaskMeaning::kSilhouette);
  EXPECT_EQ(config.input->photos.masks.folder, file.folder() / "masks");
  EXPECT_EQ(config.input->photos.masks.erode_px, 2);
  EXPECT_EQ(config.input->exposure_model, ExposureUnknown::kGain);
  EXPECT_EQ(config.input->photos.validation_every, 8);
  EXPECT_EQ(config.input->photos.max_size_px, 0);

  ASSERT_EQ(config.geometry.size(), 2U);
  EXPECT_EQ(std::get<VisualHullGeometry>(config.geometry[0].geometry).resolution, 64);
  EXPECT_EQ(config.geometry[0].material, "glaze");
  EXPECT_DOUBLE_EQ(std::get<SphereGeometry>(config.geometry[1].geometry).radius, 0.1);
  ASSERT_EQ(config.materials.size(), 2U);
  EXPECT_EQ(config.materials[0].model, MaterialConfig::Model::kMetallicRoughness);
  EXPECT_EQ(config.materials[0].base_color_source, MaterialConfig::BaseColor::kVertexConstant);
  EXPECT_EQ(config.materials[0].base_color, (Triple{0.5, 0.4, 0.3}));
  EXPECT_DOUBLE_EQ(config.materials[0].gltf.roughness, 0.4);
  EXPECT_EQ(config.materials[1].base_color_source, MaterialConfig::BaseColor::kConstant);
  ASSERT_EQ(config.lights.size(), 2U);
  EXPECT_EQ(config.lights[0].size_px, (std::array<int, 2>{16, 8}));
  EXPECT_EQ(config.lights[1].type, LightConfig::Type::kPoint);
  EXPECT_EQ(config.lights[1].position, (Triple{0, 1, 0}));

  EXPECT_EQ(config.fit.loss.residual, optim::ResidualKind::kRelative);
  ASSERT_EQ(config.fit.stages.size(), 2U);
  ASSERT_EQ(config.fit.stages[0].free.size(), 2U);
  const auto freed = [&](std::size_t i) {
    return config.fit.unknowns[static_cast<std::size_t>(config.fit.stages[0].free[i])].name;
  };
  EXPECT_EQ(freed(0), "room.texels");
  EXPECT_EQ(freed(1), "exposure");
  EXPECT_EQ(config.fit.stages[1].free.size(), 7U) << "all but the held one";
  EXPECT_EQ(config.fit.stages[1].samples.spp, 16);
  EXPECT_DOUBLE_EQ(config.max_memory_bytes, 2.0 * 1024 * 1024 * 1024);
  EXPECT_EQ(config.threads, 2);
  EXPECT_EQ(config.output.directory, file.folder() / "runs/{name}/{timestamp}");
  EXPECT_EQ(config.gradcheck.params, (std::vector<std::string>{"mug.*"}));
  EXPECT_DOUBLE_EQ(config.gradcheck.check.step, 1e-4);
}

TEST(ExperimentConfig, UnknownsWaitForTheScene) {
  const ExperimentConfig config = LoadText(kFitConfig);
  ASSERT_EQ(config.fit.unknowns.size(), 8U);
  EXPECT_FALSE(UnknownOf(config, "mug.colors").hold);
  const YamlEntry& colors = config.resolved.Find("unknowns")->entries.at(1);
  EXPECT_EQ(colors.key, "mug.colors");
  EXPECT_EQ(colors.key_place.line, 26);
  ASSERT_NE(colors.value.Find("bounds"), nullptr);
  const YamlNode& bounds = *colors.value.Find("bounds");
  EXPECT_EQ(bounds.items[0].text + " " + bounds.items[1].text, "0.02 0.95");
  EXPECT_TRUE(UnknownOf(config, "glaze.metallic").hold);
  EXPECT_EQ(config.source.lines.at(25), "  mug.colors: {bounds: [0.02, 0.95]}");
}

TEST(ExperimentConfig, ValuesWithoutUseAreAcceptedAndSaid) {
  const ConfigFile file(Replaced(
      kFitConfig, "loss:", "render: {guiding: none, guide_share: 0.5, spp_pixel: 3}\nloss:"));
  const ExperimentConfig config = LoadExperimentConfig(file.path(),
                                                       Sets({"loss.residual=linear",
                                                             "loss.relative_floor=0.1",
                                                             "stages[0].spp_pixel=3",
                                                             "render.form=image"}));
  const std::vector<std::string> warnings = UselessValues(config);
  ASSERT_EQ(warnings.size(), 4U);
  EXPECT_EQ(warnings[0].find(file.path().string() + ":"), 0U) << warnings[0];
  EXPECT_NE(warnings[0].find(": render.guide_share has no use with render.guiding: none"),
            std::string::npos)
      << warnings[0];
  EXPECT_NE(warnings[1].find(": render.spp_pixel has no use with render.form: image"),
            std::string::npos)
      << warnings[1];
  EXPECT_EQ(warnings[2], "--set #2: loss.relative_floor has no use with loss.residual: linear");
  EXPECT_EQ(warnings[3], "--set #3: stages[0].spp_pixel has no use with render.form: image");

  const ExperimentConfig used = LoadText(kFitConfig,
                                         {"loss.residual=relative",
                                          "loss.relative_floor=0.1",
                                          "stages[0].spp_pixel=3",
                                          "render.form=material",
                                          "render.spp_pixel=3",
                                          "render.guiding=grid",
                                          "render.guide_share=0.5"});
  EXPECT_TRUE(UselessValues(used).empty());
  // The resolved copy of a run spells defaults, too.
  const ConfigFile copy(
      ResolvedText(LoadText(kFitConfig, {"render.guiding=none", "loss.residual=linear"})));
  EXPECT_TRUE(UselessValues(LoadExperimentConfig(copy.path(), {})).empty());
}

TEST(ExperimentConfig, ASceneNeedsNoPhotos) {
  const ConfigFile file(kSceneConfig);
  const ExperimentConfig config = LoadExperimentConfig(file.path(), {});
  EXPECT_FALSE(config.input);
  EXPECT_EQ(config.name, "test") << "the file's name";
  EXPECT_EQ(config.geometry[0].transform.scale, (Triple{2, 2, 2}));
  EXPECT_DOUBLE_EQ(config.geometry[0].transform.angle, -0.5 * std::numbers::pi);
  EXPECT_EQ(config.lights[0].type, LightConfig::Type::kConstant);
  ASSERT_EQ(config.sensors.size(), 1U);
  const SensorConfig& sensor = config.sensors[0];
  EXPECT_NEAR(sensor.focal_px[0], 16.0, 1e-12) << "90 degrees along the smaller side of 32";
  EXPECT_EQ(sensor.principal_point_px, (std::array<double, 2>{32.0, 16.0}));
  EXPECT_EQ(sensor.up, (Triple{0, 1, 0}));
}

TEST(ExperimentConfig, FieldOfViewIsMeasuredAlongTheAxisNamed) {
  const auto focal = [](const std::string& axis) {
    return LoadText(kSceneConfig, {"scene.sensors.front.fov_axis=" + axis}).sensors[0].focal_px[0];
  };
  EXPECT_NEAR(focal("x"), 32.0, 1e-12);
  EXPECT_NEAR(focal("y"), 16.0, 1e-12);
  EXPECT_NEAR(focal("larger"), 32.0, 1e-12);
  EXPECT_NEAR(focal("diagonal"), 0.5 * std::hypot(64.0, 32.0), 1e-12);
}

TEST(ExperimentConfig, ReadsInlineMeshesAndGivenPoses) {
  const ExperimentConfig config = LoadText(R"(schema: 1
scene:
  geometry:
    leaf:
      mesh:
        vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
        triangles: [[0, 1, 2]]
        colors: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
      material: own
  materials: {own: {model: diffuse, base_color: {vertex: mesh}, two_sided: false}}
  lights: {sun: {type: directional, direction: [0, -1, 0], irradiance: [3, 2, 1], frame: camera}}
  sensors:
    a:
      size_px: [8, 8]
      focal_px: [9, 10]
      principal_point_px: [4, 4.5]
      distortion: {k1: 0.1, p2: -0.2}
      pose: {world_from_camera: [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]}
      crop_px: [0, 4, 8, 4]
      exposure_ev: -1
)");
  const auto& mesh = std::get<InlineGeometry>(config.geometry[0].geometry);
  EXPECT_EQ(mesh.vertices.size(), 3U);
  EXPECT_EQ(mesh.triangles[0], (std::array<int, 3>{0, 1, 2}));
  EXPECT_EQ(mesh.colors[2], (Triple{0, 0, 1}));
  EXPECT_EQ(config.materials[0].base_color_source, MaterialConfig::BaseColor::kVertexOfMesh);
  EXPECT_FALSE(config.materials[0].two_sided);
  EXPECT_EQ(config.lights[0].intensity, (Triple{3, 2, 1}));
  EXPECT_TRUE(config.lights[0].camera_frame);
  const SensorConfig& sensor = config.sensors[0];
  EXPECT_EQ(sensor.focal_px, (std::array<double, 2>{9, 10}));
  EXPECT_FALSE(sensor.look_at);
  EXPECT_DOUBLE_EQ(sensor.world_from_camera[2][3], 3.0);
  EXPECT_EQ(*sensor.crop_px, (std::array<int, 4>{0, 4, 8, 4}));
  EXPECT_DOUBLE_EQ(sensor.distortion.p2, -0.2);
  EXPECT_DOUBLE_EQ(sensor.exposure_ev, -1.0);
}

TEST(ExperimentConfig, PathsAreRelativeToTheFileAndExpanded) {
  setenv("PATHFIT_TEST_FOLDER", "/data/x", 1);
  setenv("HOME", "/home/somebody", 1);
  const ConfigFile file(kFitConfig);
  const auto images = [&file](const std::string& text) {
    const auto config = LoadExperimentConfig(file.path(), Sets({"input.images=" + text}));
    return config.input->photos.images_dir.string();
  };
  EXPECT_EQ(images("a/../b/"), (file.folder() / "b").string());
  EXPECT_EQ(images("../c"), (file.folder().parent_path() / "c").string());
  EXPECT_EQ(images("/abs/photos"), "/abs/photos");
  EXPECT_EQ(images("\"${PATHFIT_TEST_FOLDER}/photos\""), "/data/x/photos");
  EXPECT_EQ(images("~/photos"), "/home/somebody/photos");
  EXPECT_EQ(images("a~b"), (file.folder() / "a~b").string());
  EXPECT_EQ(ProblemOf(kFitConfig, {"input.images=\"${PATHFIT_NOT_SET}/a\""}),
            "--set #1: input.images: environment variable 'PATHFIT_NOT_SET' is not set");
  EXPECT_EQ(ProblemOf(kFitConfig, {"input.images=\"${PATHFIT_NOT_SET\""}),
            "--set #1: input.images: '${' is never closed by '}'");
}

TEST(ExperimentConfig, AMissingFileIsNamed) {
  try {
    LoadExperimentConfig("/nowhere/a.yaml", {});
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("/nowhere/a.yaml: error: the config cannot be opened"),
              std::string::npos);
  }
}

TEST(ExperimentConfig, ListsAllProblemsInTheOrderOfTheFile) {
  std::string text = Replaced(kFitConfig, "seed: 7", "sed: 7");
  text = Replaced(text, "erode_px: 2", "invert: no");
  text = Replaced(text, "material: paint", "material: pant");
  text = Replaced(text, "room.texels, exposure", "room.texel, exposure");
  text = Replaced(text, "max_rounds: 3", "max_iterations: 3");
  const std::vector<std::string> expected = {
      "3:1: unknown key 'sed' (did you mean 'seed'?)",
      "7:32: input.masks.invert: 'no' is not a boolean here; write false",
      "14:60: scene.geometry.disc.material: no material is called 'pant' (did you mean 'paint'?)",
      "35:26: stages[0].free: no unknown is called 'room.texel' (did you mean 'room.texels'?)",
      "35:68: stages[0]: key 'max_iterations' is not supported; write max_rounds",
      "--set #1: render.spp: 0 is out of range (allowed: a whole number from 1 to 1048576)",
  };
  EXPECT_EQ(ProblemsOf(text, {"render.spp=0"}), expected);
}

}  // namespace
}  // namespace pathfit::app::experiment_config_test
