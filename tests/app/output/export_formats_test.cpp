#include <cmath>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/output/export_blender.h"
#include "app/output/export_cameras.h"
#include "app/output/export_obj.h"
#include "app/output/fields.h"
#include "optim/observation/camera_import.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/image_file.h"
#include "renderer/io/mesh_file.h"
#include "renderer/io/texture_file.h"
#include "tests/app/output/synthetic_run.h"
#include "tests/support/test_scenes.h"

namespace pathfit::app::export_formats_test {
namespace {

namespace fs = std::filesystem;
using renderer::Mesh;
using renderer::Rgb;

class ExportFormatsTest : public ::testing::Test {
 protected:
  ExportFormatsTest()
      : folder_(fs::temp_directory_path() / ("pathfit_formats_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~ExportFormatsTest() override { fs::remove_all(folder_); }
  fs::path folder_;
};

/// A ball whose positions are no short decimals, with a colour for each vertex.
Mesh ColoredBall() {
  Mesh ball = renderer::MakeIcosphere(1, 1.0 / 3.0);
  for (const renderer::Vec3& p : ball.positions) {
    const renderer::Vec3 n = Normalized(p);
    ball.colors.push_back({0.5 + 0.4 * n.x, 0.5 + 0.4 * n.y, 0.5 + 0.4 * n.z});
  }
  ball.color_triangles = ball.triangles;
  return ball;
}

TEST_F(ExportFormatsTest, ObjReadsBackWithTheColoursOfItsVertices) {
  const Mesh ball = ColoredBall();
  const std::vector<fs::path> files = WriteObj(folder_ / "ball", ball, {.name = "a paint"});
  ASSERT_EQ(files.size(), 3U);
  const Mesh read = renderer::ReadMesh(files[0]);
  ASSERT_EQ(read.positions.size(), ball.positions.size());
  for (std::size_t i = 0; i < read.positions.size(); ++i) {
    EXPECT_EQ(read.positions[i], ball.positions[i]);
  }
  EXPECT_EQ(read.triangles, ball.triangles);
  // What a viewer sees: the picture, bilinear, at the corners and in the middle of each triangle.
  const renderer::Texture picture = renderer::ReadTexture(files[2], renderer::TextureRole::kColor);
  ASSERT_EQ(read.uv_triangles.size(), ball.triangles.size());
  constexpr double kByte = 0.006;  // of sRGB, in linear values
  for (std::size_t f = 0; f < ball.triangles.size(); ++f) {
    renderer::Vec2 middle{0.0, 0.0};
    Rgb mean{0.0, 0.0, 0.0};
    for (std::size_t i = 0; i < 3; ++i) {
      const renderer::Vec2 uv = read.uvs[static_cast<std::size_t>(read.uv_triangles[f][i])];
      const Rgb color = ball.colors[static_cast<std::size_t>(ball.color_triangles[f][i])];
      const Rgb seen = renderer::TextureValue(picture, uv);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], color[c], kByte);
      middle = middle + uv * (1.0 / 3.0);
      mean = mean + color * (1.0 / 3.0);
    }
    const Rgb seen = renderer::TextureValue(picture, middle);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], mean[c], kByte);
  }
  const std::string mtl = renderer::ReadWholeFile(files[1]);
  EXPECT_NE(mtl.find("newmtl a_paint\n"), std::string::npos);
  EXPECT_NE(mtl.find("map_Kd ball.png\n"), std::string::npos);
}

TEST_F(ExportFormatsTest, ObjOfOneColourHasNoPicture) {
  Mesh ball = renderer::MakeIcosphere(0, 1.0);
  const std::vector<fs::path> files = WriteObj(
      folder_ / "ball", ball, {.base_color = {0.25, 0.5, 0.75}, .bsdf = {.roughness = 0.5}});
  ASSERT_EQ(files.size(), 2U);
  const std::string mtl = renderer::ReadWholeFile(files[1]);
  EXPECT_NE(mtl.find("Kd 0.25 0.5 0.75\n"), std::string::npos) << mtl;
  EXPECT_NE(mtl.find("Pr 0.5\n"), std::string::npos) << mtl;
}

/// What the script unpacks.
Json DataOf(const std::string& script) {
  const std::string begin = "json.loads(";
  const std::size_t at = script.find(begin) + begin.size();
  const std::string literal = script.substr(at, script.find('\n', at) - at - 1);
  return Json::parse(Json::parse(literal).get<std::string>());
}

TEST_F(ExportFormatsTest, CamerasReadBackToTheSameBits) {
  std::vector<renderer::Camera> cameras(200);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const auto t = static_cast<double>(i);
    renderer::Camera& camera = cameras[i];
    names.push_back("photo " + std::to_string(i) + ".jpg");
    camera.name = names.back();
    camera.width = 640;
    camera.height = 480;
    camera.fx = 500.0 + 1.0 / 3.0 * t;
    camera.fy = 501.0 - 0.1 * t;
    camera.cx = 320.1;
    camera.cy = 239.7;
    camera.distortion = {.k1 = 0.1 / (1.0 + t), .k2 = -1e-3 * t, .k3 = 1e-7 * t, .p1 = 1e-4};
    camera.vignetting = {-0.1 / 3.0 * t, 0.01, i == 1 ? 0.0 : -1e-3 / 7.0};
    camera.world_from_camera = {renderer::RotationFromVector({0.1 * t, std::sin(t), -0.03 * t}),
                                {t / 7.0, -1.0 / 3.0, 2.0}};
    camera.rotation = {0.01 * std::cos(t), 0.3, 0.002 * t};  // two rotations' rounding
  }
  const fs::path path = folder_ / "transforms.json";
  std::ofstream(path) << TransformsJson(cameras, names, 1.0 / 3.0);
  const optim::ImportedCameras read = optim::ImportCameras(path, "auto");
  EXPECT_EQ(read.metres_per_unit, 1.0 / 3.0);
  std::vector<renderer::Camera> again;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const renderer::Camera& camera = again.emplace_back(read.cameras[i].camera);
    const renderer::Transform pose = renderer::CameraPose(cameras[i]);
    EXPECT_EQ(camera.world_from_camera.linear.x, pose.linear.x) << i;
    EXPECT_EQ(camera.world_from_camera.linear.y, pose.linear.y) << i;
    EXPECT_EQ(camera.world_from_camera.linear.z, pose.linear.z) << i;
    EXPECT_EQ(camera.world_from_camera.translation, pose.translation) << i;
    EXPECT_EQ(camera.fx, cameras[i].fx);
    EXPECT_EQ(camera.cy, cameras[i].cy);
    EXPECT_EQ(camera.distortion.k3, cameras[i].distortion.k3);
    EXPECT_EQ(camera.vignetting, cameras[i].vignetting);
  }
  EXPECT_EQ(TransformsJson(again, names, 1.0 / 3.0), renderer::ReadWholeFile(path));
  cameras[3].projection = renderer::ProjectionKind::kOrthographic;
  cameras[3].distortion = {};
  names[4] = "odd: \"name\" #1.jpg";
  std::ofstream(folder_ / "cameras.yaml") << CameraListYaml(cameras, names, 1.0 / 3.0);
  const optim::ImportedCameras list = optim::ImportCameras(folder_ / "cameras.yaml", "auto");
  EXPECT_EQ(list.format, "list of cameras");
  again.clear();
  std::vector<std::string> images;
  for (const optim::ImportedCamera& camera : list.cameras) {
    again.push_back(camera.camera);
    images.push_back(camera.image);
  }
  EXPECT_EQ(images, names);
  EXPECT_EQ(TransformsJson(again, images, list.metres_per_unit),
            TransformsJson(cameras, names, 1.0 / 3.0));
  cameras[3] = cameras[5];
  // Quaternions hold a rotation to rounding only.
  const ColmapText text = ColmapModel(cameras, names);
  std::ofstream(folder_ / "cameras.txt") << text.cameras;
  std::ofstream(folder_ / "images.txt") << text.images;
  const optim::ImportedCameras colmap = optim::ImportCameras(folder_, "colmap");
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const renderer::Transform& a = colmap.cameras[i].camera.world_from_camera;
    const renderer::Transform b = renderer::CameraPose(cameras[i]);
    EXPECT_LT(Norm(a.linear.x - b.linear.x) + Norm(a.linear.y - b.linear.y), 5e-15);
    EXPECT_LT(Norm(a.translation - b.translation), 1e-13);
    EXPECT_EQ(colmap.cameras[i].camera.fx, cameras[i].fx);
    EXPECT_EQ(colmap.cameras[i].image, names[i]);
  }
}

TEST_F(ExportFormatsTest, BlenderGetsCamerasLightsAndMeshes) {
  renderer::Scene scene = tests::BallAndWall();
  scene.sensors[0].name = "a\"quoted\"\nphoto.jpg";
  scene.sensors[0].gain = 2.0;
  const renderer::Emitter room{
      "room", renderer::LightFrame::kCamera, {}, renderer::EnvironmentEmitter{}};
  const renderer::Emitter spot{"spot", renderer::LightFrame::kWorld, {}, renderer::SpotEmitter{}};
  scene.emitters = {room, spot};
  const std::vector<std::string> meshes(scene.meshes.size(), "m.glb");
  const std::string script = BlenderScript(scene, meshes, 3);
  const Json data = DataOf(script);
  ASSERT_EQ(data.at("cameras").size(), scene.sensors.size());
  EXPECT_EQ(data.at("cameras")[0].at("name"), scene.sensors[0].name);
  EXPECT_EQ(data.at("cameras")[0].at("exposure"), 1.0);
  EXPECT_EQ(data.at("cameras")[0].at("focal"), scene.sensors[0].fx);
  ASSERT_EQ(data.at("lights").size(), 1U);
  EXPECT_EQ(data.at("lights")[0].at("follows"), true);
  EXPECT_EQ(data.at("max_bounces"), 2);
  EXPECT_EQ(data.at("meshes")[0].at("file"), "m.glb");
  const std::vector<std::string> gaps = BlenderGaps(scene);
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_NE(gaps[0].find("light 'spot' is not set up"), std::string::npos);
}

TEST_F(ExportFormatsTest, MeshesThatShineDoSoInBlender) {
  renderer::Scene scene = tests::BallAndWall();
  renderer::AreaEmitter lamp{.mesh = 1, .intensity = {4.0, 2.0, 1.0}, .two_sided = true};
  scene.emitters = {{"lamp", renderer::LightFrame::kWorld, {}, lamp}};
  const std::vector<std::string> files(scene.meshes.size(), "m.glb");
  const Json meshes = DataOf(BlenderScript(scene, files, 1)).at("meshes");
  EXPECT_FALSE(meshes[0].contains("radiance"));
  EXPECT_EQ(meshes[1].at("radiance"), Json::array({4.0, 2.0, 1.0}));
  EXPECT_EQ(meshes[1].at("two_sided"), true);
  EXPECT_TRUE(BlenderGaps(scene).empty());
  lamp.texture = 0;
  scene.emitters[0].light = lamp;
  ASSERT_EQ(BlenderGaps(scene).size(), 1U);
  EXPECT_NE(BlenderGaps(scene)[0].find("texture"), std::string::npos);
}

}  // namespace
}  // namespace pathfit::app::export_formats_test
