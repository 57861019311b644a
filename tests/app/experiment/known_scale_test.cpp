#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/experiment/experiment.h"
#include "renderer/core/error.h"
#include "renderer/io/image_file.h"
#include "tests/app/config/config_text.h"

// How long the unit of a camera file is, by two points a known distance apart.
namespace pathfit::app::known_scale_test {
namespace {

namespace fs = std::filesystem;
using renderer::Image;
using renderer::Vec3;

constexpr const char* kCameras = R"(size_px: [90, 60]
focal_px: 80
distortion: {k1: -0.05}
cameras:
- {image: a.png, look_at: {origin: [0, 1, 5], target: [0, 0, 0]}}
- {image: b.png, look_at: {origin: [4, 1, 3], target: [0, 0, 0]}}
- {image: c.png, look_at: {origin: [0.05, 1, 5], target: [0, 0, 0]}}
)";
constexpr const char* kSensor = "{sensor: front}";
constexpr const char* kSensors =
    "  sensors: {front: {size_px: [90, 60], fov_deg: 40, pose: {look_at: {origin_m: [0, 0, 5], "
    "target_m: [0, 0, 0]}}}}\n";
constexpr const char* kScene = R"(  max_size_px: 30
scene:
  geometry: {ball: {primitive: {sphere: {subdivisions: 2}}, material: clay}}
  materials: {clay: {model: diffuse, base_color: {constant: [0.5, 0.5, 0.5]}}}
  lights: {room: {type: constant, radiance: [1, 1, 1]}}
)";

class KnownScale : public testing::Test {
 protected:
  KnownScale() : file_("") {
    for (const char* name : {"a.png", "b.png", "c.png"}) {
      renderer::WritePng8(file_.folder() / name, Image(90, 60, 3));
    }
    WriteCameras("");
  }
  void WriteCameras(const std::string& extra) const {
    std::ofstream(file_.folder() / "cameras.yaml") << kCameras << extra;
  }
  [[nodiscard]] Experiment Build(const std::string& scale,
                                 const std::string& cameras = "{path: cameras.yaml}") const {
    file_.Write("schema: 1\ninput:\n  images: .\n  cameras: " + cameras + "\n  scale: " + scale +
                "\n" + kScene + (cameras == kSensor ? kSensors : ""));
    return BuildExperiment(LoadExperimentConfig(file_.path(), {}));
  }
  /// "LINE:COLUMN: path: text" of each.
  [[nodiscard]] std::vector<std::string> Problems(
      const std::string& scale, const std::string& cameras = "{path: cameras.yaml}") const {
    try {
      static_cast<void>(Build(scale, cameras));
    } catch (const ConfigError& error) {
      return ProblemsIn(error, file_);
    }
    return {};
  }
  /// A map of the photos to where a camera of the full size sees the point.
  [[nodiscard]] std::string Picked(const Vec3& point, const std::string& photos) const {
    const Experiment experiment = Build("{two_points: [[0, 0, 0], [1, 0, 0]], distance_m: 1}");
    std::string text;
    for (const char photo : photos) {
      const auto view = static_cast<std::size_t>(photo - 'a');
      const renderer::Camera camera =
          renderer::ScaledCamera(experiment.observations.views[view].camera, 90, 60);
      const auto seen = renderer::CameraModel(camera).Project(point);
      text += fmt::format("{}{}: [{}, {}]", text.empty() ? "" : ", ", photo, seen->u, seen->v);
    }
    return "{" + text + "}";
  }
  static std::string ScaleSentence(const Experiment& experiment) {
    for (const std::string& text : experiment.assumptions) {
      if (text.starts_with("Scale: ")) return text;
    }
    return "";
  }
  static void ExpectOne(const std::vector<std::string>& problems, const std::string& part) {
    ASSERT_EQ(problems.size(), 1U);
    EXPECT_NE(problems[0].find(part), std::string::npos) << problems[0];
  }

  ConfigFile file_;
};

TEST_F(KnownScale, IsThatOfTwoPointsOfTheCameraFile) {
  const Experiment experiment =
      Build("{two_points: [[0.1, 0.02, 0.3], [0.5, 0.32, 0.3]], distance_m: 0.05}");
  EXPECT_DOUBLE_EQ(experiment.observations.metres_per_unit, 0.1);
  EXPECT_EQ(ScaleSentence(experiment),
            "Scale: 1 unit of the camera file is 0.1 m, as two points 0.5 units apart are 0.05 m; "
            "the file does not say; poses stay in units of the file.");
  EXPECT_EQ(experiment.scene.sensors[0].world_from_camera.translation, (Vec3{0, 1, 5}));
}

TEST_F(KnownScale, OverridesWhatTheCameraFileSays) {
  WriteCameras("metres_per_unit: 0.02\n");
  const Experiment experiment = Build("{two_points: [[0, 0, 0], [0, 2, 0]], distance_m: 0.08}");
  EXPECT_DOUBLE_EQ(experiment.observations.metres_per_unit, 0.04);
  EXPECT_EQ(ScaleSentence(experiment),
            "Scale: 1 unit of the camera file is 0.04 m, as two points 2 units apart are 0.08 m; "
            "the file says 0.02 m, which is not used; poses stay in units of the file.");
}

TEST_F(KnownScale, IsThatOfPointsPickedInPhotos) {
  // Pixels of the files, although photos are kept at a third, through the lens.
  const std::string points =
      fmt::format("[{}, {}]", Picked({0.4, -0.2, 0.3}, "abc"), Picked({-0.4, 0.4, 0.3}, "ab"));
  const Experiment experiment = Build("{two_points: " + points + ", distance_m: 0.25}");
  EXPECT_NEAR(experiment.observations.metres_per_unit, 0.25, 1e-9);
  EXPECT_NE(ScaleSentence(experiment)
                .find("1 units apart (picked in photos, to 0.0, 0.0, 0.0, "
                      "0.0, 0.0 pixels) are 0.25 m"),
            std::string::npos)
      << ScaleSentence(experiment);
}

TEST_F(KnownScale, MayMixBothKindsOfPoints) {
  const std::string picked = Picked({0.0, 0.5, 0.0}, "ab");
  const Experiment experiment = Build("{two_points: [" + picked + ", [0, 0, 0]], distance_m: 1}");
  EXPECT_NEAR(experiment.observations.metres_per_unit, 2.0, 1e-8);
}

TEST_F(KnownScale, WrongValuesAreRefusedAtTheirPlaces) {
  const auto expect = [&](const std::string& scale, const std::string& part) {
    SCOPED_TRACE(scale);
    ExpectOne(Problems(scale), part);
  };
  expect("{distance_m: 1}", "5:10: input.scale: required key 'two_points' is missing");
  expect("{two_points: [[0, 0, 0], [1, 0, 0]]}",
         "5:10: input.scale: required key 'distance_m' is missing");
  expect("{two_points: [[0, 0, 0], [1, 0, 0]], distance_m: 0}", "5:59: input.scale.distance_m: ");
  expect("{two_points: [[0, 0, 0]], distance_m: 1}", "5:23: input.scale.two_points: ");
  expect("{two_points: [[0, 0], [1, 0, 0]], distance_m: 1}", "5:24: input.scale.two_points[0]: ");
  expect("{two_points: [[0, 0, 0], {a: [1, 2, 3], b: [1, 2]}], distance_m: 1}",
         "5:39: input.scale.two_points[1].a: ");
  expect("{two_points: [[0, 0, 0], {a: [1, 2]}], distance_m: 1}",
         "5:35: input.scale.two_points[1]: one photo does not tell how far away");
  expect("{two_points: [[1, 2, 3], [1, 2, 3]], distance_m: 1}",
         "input.scale.two_points: both points are the same");
  expect("{two_points: [[1e300, 0, 0], [-1e300, 0, 0]], distance_m: 1}", "too far away");
}

TEST_F(KnownScale, WrongPicksAreRefusedTogether) {
  const std::string good = Picked({0.0, 0.5, 0.0}, "ab");
  const std::vector<std::string> problems = Problems(
      "{two_points: [{a: [1, 2], d.png: [3, 4], b: [91, 5]}, {'*': [1, 2], b: [3, 4]}], "
      "distance_m: 1}");
  ASSERT_EQ(problems.size(), 3U);
  EXPECT_NE(
      problems[0].find("5:36: input.scale.two_points[0]: no photo or sensor is called 'd.png'"),
      std::string::npos)
      << problems[0];
  EXPECT_NE(problems[1].find("the pixel is outside of b.png"), std::string::npos) << problems[1];
  EXPECT_NE(problems[2].find("'*' stands for 3 photos"), std::string::npos) << problems[2];
  ExpectOne(Problems("{two_points: [{a: [1, 2], a.png: [1, 2]}, [0, 0, 0]], distance_m: 1}"),
            "'a.png' is there twice");
  ExpectOne(
      Problems("{two_points: [" + Picked({0.0, 0.5, 0.0}, "ac") + ", [0, 0, 0]], distance_m: 1}"),
      "from nearly the same side");
  ExpectOne(Problems("{two_points: [{a: [50, 5], b: [45, 55]}, [0, 0, 0]], distance_m: 1}"),
            "do not belong together");
  ExpectOne(Problems("{two_points: [" + good + ", " + good + "], distance_m: 1}"),
            "both points are the same");
}

TEST_F(KnownScale, IsOfCameraFilesOnly) {
  ExpectOne(Problems("{two_points: [[0, 0, 0], [1, 0, 0]], distance_m: 1}", kSensor),
            "sensors of the scene are in metres");
}

}  // namespace
}  // namespace pathfit::app::known_scale_test
