#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/experiment/experiment.h"
#include "app/output/export_result.h"
#include "renderer/core/error.h"
#include "renderer/io/image_file.h"
#include "tests/app/config/config_text.h"

// One camera that stood still, lamps that were switched, exposures that are known.
namespace pathfit::app::photo_lights_test {
namespace {

namespace fs = std::filesystem;
using renderer::Image;

constexpr const char* kScene = R"(scene:
  geometry: {ball: {primitive: {sphere: {subdivisions: 2}}, material: clay}}
  materials: {clay: {model: diffuse, base_color: {constant: [0.5, 0.5, 0.5]}}}
  lights:
    left: {type: directional, direction: [1, 0, -1], irradiance: [2, 2, 2], photos: [a]}
    right: {type: directional, direction: [-1, 0, -1], irradiance: [2, 2, 2], photos: ["[bc].png"]}
    room: {type: constant, radiance: [0.1, 0.1, 0.1]}
  sensors:
    front: {type: orthographic, size_px: [12, 8], height_m: 4, pose: {look_at: {origin_m: [0, 0, 5], target_m: [0, 0, 0]}}}
)";

class OneCamera : public testing::Test {
 protected:
  OneCamera() : file_("") {
    fs::create_directories(file_.folder() / "photos");
    for (const char* name : {"a.png", "b.png", "c.png"}) {
      renderer::WritePng8(file_.folder() / "photos" / name, Image(12, 8, 3));
    }
    Image mask(12, 8, 1);
    mask.At(6, 4, 0) = 1.0F;
    renderer::WritePng8(file_.folder() / "mask.png", mask);
    std::ofstream(file_.folder() / "photos" / "notes.txt") << "no picture";
  }

  Experiment Build(const std::string& input, const std::vector<std::string>& sets = {}) const {
    file_.Write("schema: 1\ninput:\n" + input + kScene);
    return BuildExperiment(LoadExperimentConfig(file_.path(), Sets(sets)));
  }
  std::string Problem(const std::string& input, const std::vector<std::string>& sets = {}) const {
    try {
      Build(input, sets);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "no problem";
  }

  ConfigFile file_;
};

constexpr const char* kInput = "  images: photos\n  cameras: {sensor: front}\n";

TEST_F(OneCamera, TookEveryPictureOfTheFolder) {
  const Experiment experiment = Build(kInput);
  ASSERT_EQ(experiment.scene.sensors.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const renderer::Camera& camera = experiment.scene.sensors[i];
    EXPECT_EQ(camera.name, std::string(1, static_cast<char>('a' + i)) + ".png");
    EXPECT_EQ(camera.projection, renderer::ProjectionKind::kOrthographic);
    EXPECT_EQ(camera.width, 12);
    EXPECT_EQ(camera.world_from_camera.translation, (renderer::Vec3{0, 0, 5}));
  }
  EXPECT_EQ(experiment.observations.assumptions.front(),
            "Cameras: one that stood still, front, took 3 photos.");
}

TEST_F(OneCamera, MayHaveTakenSomeOfThePictures) {
  const Experiment experiment =
      Build("  images: photos\n  cameras: {sensor: front, photos: ['[ab]']}\n");
  EXPECT_EQ(experiment.scene.sensors.size(), 2U);
  const std::string text =
      Problem("  images: photos\n  cameras: {sensor: front, photos: [a, bb]}\n");
  EXPECT_NE(text.find("test.yaml:4:40: error: input.cameras.photos: no photo or sensor is called "
                      "'bb'"),
            std::string::npos)
      << text;
}

TEST_F(OneCamera, LightsShineInTheirPhotosAlone) {
  const Experiment experiment = Build(kInput);
  EXPECT_EQ(experiment.scene.sensors[0].lights_off, std::vector<int>{1});
  EXPECT_EQ(experiment.scene.sensors[1].lights_off, std::vector<int>{0});
  EXPECT_EQ(experiment.scene.sensors[2].lights_off, std::vector<int>{0});
  const std::string lights = LightsJson(experiment.scene);
  EXPECT_NE(lights.find("\"a.png\""), std::string::npos) << lights;
}

TEST_F(OneCamera, LightsMayNameSensorsWithoutPhotos) {
  file_.Write(std::string("schema: 1\n") + kScene);
  const ExperimentConfig config = LoadExperimentConfig(
      file_.path(), Sets({"scene.lights.left.photos=[fr*]", "scene.lights.right.photos=[front]"}));
  EXPECT_TRUE(BuildExperiment(config).scene.sensors[0].lights_off.empty());
}

TEST_F(OneCamera, UnknownPhotosOfLightsAreNamedAtTheirPlace) {
  const std::string text = Problem(kInput, {"scene.lights.right.photos=[b, d.png]"});
  EXPECT_NE(text.find("--set #1"), std::string::npos) << text;
  EXPECT_NE(text.find("no photo or sensor is called 'd.png'"), std::string::npos) << text;
}

TEST_F(OneCamera, AnUnknownThatShinesInNoFittedPhotoIsAWarning) {
  file_.Write("schema: 1\ninput:\n" + std::string(kInput) + "  split: {validation: [a.png]}\n" +
              kScene + "unknowns: {left.intensity: {}, right.intensity: {}}\n");
  const Experiment experiment = BuildExperiment(LoadExperimentConfig(file_.path(), {}));
  ASSERT_EQ(experiment.warnings.size(), 1U);
  EXPECT_EQ(experiment.warnings[0].substr(0, 47),
            "left.intensity: the light shines in no fitted p");
}

TEST_F(OneCamera, HasOnePlaceAndOneLens) {
  file_.Write(
      "schema: 1\ninput:\n" + std::string(kInput) + kScene +
      "unknowns: {camera.position: {}, camera.focal: {}, camera.rotation: {shared: false}}\n");
  const Experiment experiment = BuildExperiment(LoadExperimentConfig(file_.path(), {}));
  EXPECT_TRUE(experiment.warnings.empty());
  const std::size_t num_photos = experiment.observations.views.size();
  for (const std::size_t i : {0U, 1U}) {
    EXPECT_EQ(experiment.fit.unknowns[i].sharing, std::vector<int>(num_photos, 0)) << i;
  }
  EXPECT_TRUE(experiment.fit.unknowns[2].sharing.empty());
  EXPECT_NE(std::ranges::find(
                experiment.assumptions,
                "camera.position is one for all " + std::to_string(num_photos) + " photos."),
            experiment.assumptions.end());
}

TEST_F(OneCamera, APhotoWithoutLightIsAWarning) {
  const std::vector<std::string> sets = {"scene.lights.right.photos=[b]",
                                         "scene.lights.room.photos=[b]"};
  const Experiment experiment = Build(kInput, sets);
  ASSERT_EQ(experiment.warnings.size(), 1U);
  EXPECT_EQ(experiment.warnings[0].substr(0, 33), "c.png: no light shines in this ph");
}

TEST_F(OneCamera, KnownExposuresAreTheStartsOfGains) {
  const Experiment experiment =
      Build(std::string(kInput) + "  exposure: {model: gain, ev: {a: -2, 'b*': 1}}\n");
  EXPECT_EQ(experiment.scene.sensors[0].gain, 0.25);
  EXPECT_EQ(experiment.scene.sensors[1].gain, 2.0);
  EXPECT_EQ(experiment.scene.sensors[2].gain, 1.0);
}

TEST_F(OneCamera, KnownExposuresNeedOnePhotoEach) {
  const std::string twice = Problem(std::string(kInput) + "  exposure: {ev: {a: -2, '*': 1}}\n");
  EXPECT_NE(twice.find("test.yaml:5:26"), std::string::npos) << twice;
  EXPECT_NE(twice.find("'a.png' has one by 'a' already"), std::string::npos) << twice;
  const std::string none = Problem(std::string(kInput) + "  exposure: {ev: {x.png: -2}}\n");
  EXPECT_NE(none.find("no photo or sensor is called 'x.png'"), std::string::npos) << none;
}

TEST_F(OneCamera, OneMaskServesAllPhotos) {
  const Experiment experiment = Build(std::string(kInput) + "  masks: {path: mask.png}\n");
  for (const optim::View& view : experiment.observations.views) {
    EXPECT_EQ(view.mask.Unpack().At(6, 4, 0), 1.0F);
    EXPECT_EQ(view.mask.Unpack().At(0, 0, 0), 0.0F);
  }
}

TEST_F(OneCamera, MistakesAreSaid) {
  const auto says = [&](const std::string& input, const std::string& expected) {
    const std::string text = Problem(input);
    EXPECT_NE(text.find(expected), std::string::npos) << text;
  };
  says("  cameras: {sensor: front}\n", "give the folder of the photos: input.images");
  says("  images: photos\n  cameras: {sensor: fornt}\n", "did you mean 'front'?");
  says("  images: nowhere\n  cameras: {sensor: front}\n", "has no pictures of camera 'front'");
  says("  images: photos\n  cameras: {}\n", "one of the keys path, sensor is needed");
  renderer::WritePng8(file_.folder() / "photos" / "d.png", Image(13, 8, 3));
  says(kInput, "13x8 pixels, but its camera says 12x8");
}

}  // namespace
}  // namespace pathfit::app::photo_lights_test
