#include "app/output/viewed_model.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/geometry/mesh_normals.h"
#include "renderer/io/atomic_file.h"
#include "tests/app/output/synthetic_run.h"

namespace pathfit::app::viewed_model_test {
namespace {

using renderer::Vec3;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string Decoded(const std::string& base64) {
  const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned value = 0;
  int bits = 0;
  for (const char c : base64) {
    if (c == '=') break;
    value = value << 6U | static_cast<unsigned>(alphabet.find(c));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(value >> static_cast<unsigned>(bits) & 255U);
  }
  return bytes;
}

template <class T>
std::vector<T> Items(const Json& base64) {
  const std::string bytes = Decoded(base64.get<std::string>());
  EXPECT_EQ(bytes.size() % sizeof(T), 0U);
  std::vector<T> items(bytes.size() / sizeof(T));
  std::memcpy(items.data(), bytes.data(), bytes.size());
  return items;
}

/// A unit square in the plane z = 0 that is seen from z = 3 and from z = -3, and from a held-out
/// camera.
struct Square {
  optim::ObservationSet set = MakeObservations(3, 40, 30);
  renderer::Scene scene;
  renderer::Mesh& mesh() { return scene.meshes[0].mesh; }

  Square() {
    for (std::size_t i = 0; i < set.views.size(); ++i) {
      optim::View& view = set.views[i];
      view.validation = i == 0;
      view.mask = {};
      renderer::Camera& camera = view.camera;
      camera.fx = camera.fy = 40.0;
      camera.cx = 20.0;
      camera.cy = 15.0;
      camera.world_from_camera.translation = {0.5, 0.5, 3.0};
      scene.sensors.push_back(camera);
    }
    set.mask_meaning = optim::MaskMeaning::kNone;
    // About x by half a turn: it looks along +z.
    renderer::Transform& behind = scene.sensors[2].world_from_camera;
    behind = {renderer::RotationFromVector({M_PI, 0.0, 0.0}), {0.5, 0.5, -3.0}};
    renderer::SceneMesh square;
    square.name = "square";
    square.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    square.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    square.mesh.colors = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0.5, 0.5}};
    square.mesh.color_triangles = {{0, 1, 2}, {0, 2, 3}};
    scene.meshes.push_back(square);
    scene.materials.push_back({.name = "paint",
                               .bsdf = renderer::MetallicRoughnessBsdf{0.4, 0.0},
                               .vertex_colors = true});
  }
};

TEST(ViewedModel, HoldsPlacedMeshes) {
  Square square;
  square.scene.meshes[0].pose = {.translation = {10.0, 0.0, 0.0}, .scale = 2.0};
  const Json model = ViewedModel(square.scene, square.set, {});
  const Json& mesh = model.at("meshes").at(0);
  EXPECT_EQ(mesh.at("name"), "square");
  EXPECT_EQ(mesh.at("num_vertices"), 4);
  EXPECT_EQ(mesh.at("box"), Json::parse("[[10.0, 0.0, 0.0], [12.0, 2.0, 0.0]]"));
  EXPECT_EQ(Items<std::uint16_t>(mesh.at("positions")),
            (std::vector<std::uint16_t>{0, 0, 0, 65535, 0, 0, 65535, 65535, 0, 0, 65535, 0}));
  EXPECT_EQ(Items<std::uint16_t>(mesh.at("triangles")),
            (std::vector<std::uint16_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(Items<std::uint8_t>(mesh.at("colors")),
            (std::vector<std::uint8_t>{255, 0, 0, 0, 255, 0, 0, 0, 255, 188, 188, 188}));
  EXPECT_EQ(mesh.at("roughness"), 0.4);
  for (const char* absent : {"normals", "uvs", "texture", "color", "position_error"}) {
    EXPECT_FALSE(mesh.contains(absent)) << absent;
  }
}

TEST(ViewedModel, RepeatsPositionsAtSeams) {
  Square square;
  square.mesh().color_triangles = {{0, 1, 2}, {3, 2, 3}};
  renderer::ComputeVertexNormals(square.mesh());
  const Json mesh = ViewedModel(square.scene, square.set, {}).at("meshes").at(0);
  EXPECT_EQ(mesh.at("num_vertices"), 5) << "one corner has two colours";
  EXPECT_EQ(Items<std::uint8_t>(mesh.at("photos")).size(), 5U);
  EXPECT_EQ(Items<std::int8_t>(mesh.at("normals")),
            (std::vector<std::int8_t>{0, 0, 127, 0, 0, 127, 0, 0, 127, 0, 0, 127, 0, 0, 127}));
}

TEST(ViewedModel, CountsTheFittedPhotosThatShowAVertex) {
  Square square;
  const auto counts = [&square] {
    const Json model = ViewedModel(square.scene, square.set, {});
    return Items<std::uint8_t>(model.at("meshes").at(0).at("photos"));
  };
  EXPECT_EQ(counts(), (std::vector<std::uint8_t>{2, 2, 2, 2})) << "both sides count";
  // Something before one half, on one side.
  renderer::SceneMesh screen;
  screen.name = "screen";
  screen.mesh.positions = {{0.5, -9, 1}, {9, -9, 1}, {9, 9, 1}, {0.5, 9, 1}};
  screen.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  square.scene.materials.push_back({.name = "black", .bsdf = renderer::LambertBsdf{}});
  screen.material = 1;
  square.scene.meshes.push_back(screen);
  EXPECT_EQ(counts(), (std::vector<std::uint8_t>{2, 1, 1, 2}));
  square.set.views[2].validation = true;
  EXPECT_EQ(counts(), (std::vector<std::uint8_t>{1, 0, 0, 1})) << "held-out photos do not count";
  square.scene.meshes.pop_back();
  square.scene.sensors[1].world_from_camera.translation.x = 50.0;
  EXPECT_EQ(counts(), (std::vector<std::uint8_t>{0, 0, 0, 0})) << "not in the picture";
}

TEST(ViewedModel, HasStandardErrorsOfVerticesWhereAnyIsKnown) {
  Square square;
  const double nan = std::nan("");
  StandardErrorsByName errors;
  errors["square.vertices"] = {3, 4, 0, nan, nan, nan, 1, kInfinity, 1, 0, 0, 2};
  errors["square.colors"] = std::vector<double>(12, nan);
  const Json mesh = ViewedModel(square.scene, square.set, errors).at("meshes").at(0);
  const std::vector<float> known = Items<float>(mesh.at("position_error"));
  EXPECT_EQ(known[0], 5.0F);
  EXPECT_TRUE(std::isnan(known[1]));
  EXPECT_TRUE(std::isinf(known[2]));
  EXPECT_EQ(known[3], 2.0F);
  EXPECT_FALSE(mesh.contains("color_error"));
  errors["square.vertices"].pop_back();
  EXPECT_FALSE(
      ViewedModel(square.scene, square.set, errors)["meshes"][0].contains("position_error"))
      << "of another mesh";
}

TEST(ViewedModel, HasTexturesAsPictures) {
  Square square;
  renderer::Texture picture;
  picture.width = 2 * kViewedTexturePx;
  picture.height = 2;
  picture.texels = renderer::SharedVector<renderer::Rgb>(
      static_cast<std::size_t>(picture.width) * 2, {0.5, 0.5, 0.5});
  square.scene.textures = {picture};
  square.mesh().uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  square.mesh().uv_triangles = square.mesh().triangles;
  renderer::Material& paint = square.scene.materials[0];
  paint.vertex_colors = false;
  paint.base_color_texture = 0;
  const Json mesh = ViewedModel(square.scene, square.set, {}).at("meshes").at(0);
  EXPECT_FALSE(mesh.contains("colors"));
  EXPECT_EQ(Items<float>(mesh.at("uvs")), (std::vector<float>{0, 0, 1, 0, 1, 1, 0, 1}));
  EXPECT_TRUE(
      mesh.at("texture").at("uri").get<std::string>().starts_with("data:image/jpeg;base64,"));
  EXPECT_EQ(mesh.at("texture").at("size_px"), Json::array({2 * kViewedTexturePx, 2}));
  paint.base_color_texture = -1;
  paint.base_color = {1.0, 0.0, 2.0};
  EXPECT_EQ(ViewedModel(square.scene, square.set, {})["meshes"][0]["color"],
            Json::array({255, 0, 255}));
}

TEST(ViewedModel, HasCamerasWhereTheyAreAndTheEnvironment) {
  Square square;
  square.scene.sensors[2].rotation = {0.0, 0.0, M_PI / 2};
  renderer::EnvironmentEmitter sky;
  square.scene.emitters.push_back(
      {.name = "room", .frame = renderer::LightFrame::kCamera, .light = sky});
  const Json model = ViewedModel(square.scene, square.set, {});
  ASSERT_EQ(model.at("cameras").size(), 3U);
  const Json& camera = model["cameras"][2];
  EXPECT_EQ(camera.at("name"), square.set.views[2].name);
  EXPECT_EQ(camera.at("size_px"), Json::array({40, 30}));
  EXPECT_TRUE(model["cameras"][0].at("validation"));
  EXPECT_FALSE(camera.at("validation"));
  const renderer::Transform pose = renderer::CameraPose(square.scene.sensors[2]);
  const Vec3 ahead = pose.Direction({0.0, 0.0, -1.0});
  for (std::size_t r = 0; r < 3; ++r) {
    EXPECT_NEAR(
        -camera["world_from_camera"][r][2].get<double>(), ahead[static_cast<int>(r)], 1e-12);
    EXPECT_EQ(camera["world_from_camera"][r][3], pose.translation[static_cast<int>(r)]);
  }
  EXPECT_EQ(model.at("environment").at("frame"), "camera");
}

TEST(ViewedModel, IsReadBack) {
  const TemporaryFolder folder("viewed_model");
  const auto path = folder.path() / "model.json";
  EXPECT_TRUE(ReadViewedModel(path).is_null());
  Square square;
  const Json model = ViewedModel(square.scene, square.set, {});
  WriteViewedModel(path, model);
  EXPECT_EQ(ReadViewedModel(path), model);
  for (const char* bad : {"", "{", "[]", "{\"version\": 1, \"meshes\": 3, \"cameras\": []}"}) {
    renderer::WriteFileAtomically(path, bad);
    EXPECT_THROW(ReadViewedModel(path), renderer::IoError) << bad;
  }
  renderer::WriteFileAtomically(path, "{\"version\": 99}");
  EXPECT_TRUE(ReadViewedModel(path).is_null()) << "of another version";
}

}  // namespace
}  // namespace pathfit::app::viewed_model_test
