#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/output/export_blender.h"
#include "app/output/export_obj.h"
#include "app/output/fields.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/image_file.h"
#include "renderer/io/mesh_file.h"
#include "renderer/io/texture_file.h"
#include "tests/app/output/synthetic_run.h"
#include "tests/support/test_scenes.h"

namespace pathfit::app {
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

}  // namespace
}  // namespace pathfit::app
