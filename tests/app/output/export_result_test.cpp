#include "app/output/export_result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/output/coarse_asset.h"
#include "app/output/export_cameras.h"
#include "app/output/parameter_table.h"
#include "optim/observation/camera_import.h"
#include "optim/problem/fit_views.h"
#include "optim/round/surface_levels.h"
#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/gltf_reader.h"
#include "renderer/io/image_file.h"
#include "renderer/io/mesh_file.h"
#include "renderer/io/texture_file.h"
#include "tests/app/output/html_check.h"
#include "tests/app/output/synthetic_run.h"
#include "tests/optim/round/synthetic_fit.h"

namespace pathfit::app::export_result_test {
namespace {

namespace fs = std::filesystem;
using renderer::Camera;

/// A quaternion and a normalisation lie between the matrices: some units in the last place.
constexpr double kPoseTolerance = 1e-14;

std::vector<Camera> ManyCameras() {
  std::vector<Camera> cameras;
  for (int i = 0; i < 24; ++i) {
    Camera camera;
    camera.width = 640 + i % 2;
    camera.height = 480;
    camera.fx = 512.34567890123456 + i % 3;
    camera.fy = 511.0 / 3.0;
    camera.cx = 320.1;
    camera.cy = 239.7;
    if (i % 4 == 1) camera.distortion = {.k1 = -0.1, .k2 = 0.01, .p1 = 1e-3, .p2 = -2e-3};
    // Half turns about the axes, and turns close to them, are where one quaternion formula or
    // another divides by zero.
    const renderer::Vec3 main_axis{
        i % 3 == 0 ? 1.0 : 0.0, i % 3 == 1 ? 1.0 : 0.0, i % 3 == 2 ? 1.0 : 0.0};
    const renderer::Vec3 axis =
        i < 3 ? main_axis
              : renderer::Normalized(main_axis + renderer::Vec3{0.3 * std::sin(1.0 * i),
                                                                0.2 * std::cos(2.0 * i),
                                                                0.15});
    const double angle = i < 3 ? std::numbers::pi : (i < 12 ? 3.0 : 0.7 * i);
    camera.world_from_camera = {renderer::RotationAboutAxis(axis, angle), {0.1 * i, -1.0, 2.5}};
    cameras.push_back(camera);
  }
  return cameras;
}

std::vector<std::string> Names(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) names.push_back("a b/" + ViewName(static_cast<int>(i)));
  return names;
}

void ExpectSame(const std::vector<Camera>& cameras, const optim::ImportedCameras& imported) {
  ASSERT_EQ(imported.cameras.size(), cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Camera& a = cameras[i];
    const Camera& b = imported.cameras[i].camera;
    EXPECT_EQ(imported.cameras[i].image, Names(cameras.size())[i]);
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
    EXPECT_EQ(a.fx, b.fx);
    EXPECT_EQ(a.fy, b.fy);
    EXPECT_EQ(a.cx, b.cx);
    EXPECT_EQ(a.cy, b.cy);
    EXPECT_EQ(a.distortion, b.distortion);
    EXPECT_EQ(a.vignetting, b.vignetting);
    const renderer::Transform& p = a.world_from_camera;
    const renderer::Transform& q = b.world_from_camera;
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(p.linear.x[k], q.linear.x[k], kPoseTolerance) << i;
      EXPECT_NEAR(p.linear.y[k], q.linear.y[k], kPoseTolerance) << i;
      EXPECT_NEAR(p.linear.z[k], q.linear.z[k], kPoseTolerance) << i;
      EXPECT_NEAR(p.translation[k], q.translation[k], 4.0 * kPoseTolerance) << i;
    }
  }
}

TEST(ExportCameras, ImportersReadBackWhatWasWritten) {
  const TemporaryFolder folder("cameras");
  std::vector<Camera> cameras = ManyCameras();
  const std::vector<std::string> names = Names(cameras.size());
  WriteCameras(folder.path(), cameras, names, names);
  ExpectSame(cameras, optim::ReadColmapModel(folder.path() / "cameras.txt"));
  ExpectSame(cameras, optim::ReadTransformsJson(folder.path() / "transforms.json"));
  cameras[5].distortion.k3 = 0.05;
  WriteCameras(folder.path(), cameras, names, names);
  ExpectSame(cameras, optim::ReadColmapModel(folder.path() / "cameras.txt"));
  ExpectSame(cameras, optim::ReadTransformsJson(folder.path() / "transforms.json"));
  EXPECT_EQ(Count(ColmapModel(cameras, names).cameras, "FULL_OPENCV"), 1);
}

TEST(ExportCameras, OrthographicOnesAreReadBackAndAreNoneOfColmap) {
  TemporaryFolder folder("parallel_cameras");
  std::vector<Camera> cameras = ManyCameras();
  cameras.resize(1);
  cameras[0].projection = renderer::ProjectionKind::kOrthographic;
  cameras[0].distortion = {};
  WriteCameras(folder.path(), cameras, Names(1), Names(1));
  const optim::ImportedCameras read = optim::ReadTransformsJson(folder.path() / "transforms.json");
  ASSERT_EQ(read.cameras.size(), 1U);
  EXPECT_EQ(read.cameras[0].camera.projection, renderer::ProjectionKind::kOrthographic);
  EXPECT_EQ(read.cameras[0].camera.fx, cameras[0].fx);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "cameras.txt"));
  EXPECT_THROW(ColmapModel(cameras, Names(1)), renderer::SceneError);
}

TEST(ExportCameras, EqualIntrinsicsShareACamera) {
  std::vector<Camera> cameras(3, ManyCameras().front());
  EXPECT_EQ(Count(ColmapModel(cameras, Names(3)).cameras, "PINHOLE"), 1);
  cameras[1].fx += 1e-9;
  EXPECT_EQ(Count(ColmapModel(cameras, Names(3)).cameras, "PINHOLE"), 2);
}

std::vector<ExportedView> Views(const optim::ObservationSet& set) {
  std::vector<ExportedView> views;
  for (const optim::View& view : set.views) {
    views.push_back({view.name, "photos/" + view.name, view.validation});
  }
  return views;
}

TEST(ExportResult, WritesMeshesLightsAndTables) {
  const TemporaryFolder folder("export");
  const optim::ObservationSet set = MakeObservations(5, 64, 48);
  renderer::Scene scene = MakeScene(set);
  scene.sensors[2].gain = 2.0;
  const fs::path result = folder.path() / "result";
  std::vector<ExportedView> views = Views(set);
  views[2].gain_error = 0.125;
  ExportResult(result, scene, views, SummarizeParameters(MakeSpec(), scene, scene));

  const renderer::Mesh mesh = renderer::ReadMesh(result / "axe.ply");
  EXPECT_EQ(mesh.triangles.size(), scene.meshes[0].mesh.triangles.size());
  ASSERT_TRUE(mesh.HasColors());
  EXPECT_NEAR(mesh.colors[0].r, 0.6, 5e-3);  // 8 bits
  EXPECT_TRUE(renderer::ReadWholeFile(result / "axe.glb").starts_with("glTF"));

  const auto& sky = std::get<renderer::EnvironmentEmitter>(scene.emitters[0].light);
  const renderer::Image exr = renderer::ReadExr(result / "environment.exr");
  EXPECT_EQ(exr.width, 16);
  EXPECT_NEAR(exr.ColorAt(3, 2).g, (sky.intensity * sky.texels[2 * 16 + 3]).g, 1e-6);
  EXPECT_EQ(renderer::ReadImageFile(result / "environment.hdr", false).image.height, 8);

  const auto lights = nlohmann::json::parse(renderer::ReadWholeFile(result / "lights.json"));
  ASSERT_EQ(lights.at("lights").size(), 3U);
  EXPECT_EQ(lights.at("lights")[0].at("frame"), "camera");
  EXPECT_EQ(lights.at("lights")[1].at("type"), "point");

  const std::string exposure = renderer::ReadWholeFile(result / "exposure.csv");
  EXPECT_EQ(Count(exposure, "IMG_0002.jpg,0,2,1,0.125,1,1\n"), 1);
  EXPECT_EQ(Count(exposure, "IMG_0004.jpg,1,1,0,,1,1\n"), 1);
  EXPECT_EQ(Count(renderer::ReadWholeFile(result / "parameters.csv"), "\n"), 9);
}

TEST(ExportResult, CamerasAreThoseOfThePhotosFiles) {
  const TemporaryFolder folder("export_file_size");
  const optim::ObservationSet set = MakeObservations(2, 64, 48);
  const renderer::Scene scene = MakeScene(set);
  std::vector<ExportedView> views = Views(set);
  views[1].width = 256;
  views[1].height = 192;
  ExportResult(folder.path(), scene, views, {});
  const auto frames =
      nlohmann::json::parse(renderer::ReadWholeFile(folder.path() / "cameras/transforms.json"))
          .at("frames");
  EXPECT_EQ(frames[0].at("w"), 64);
  EXPECT_EQ(frames[1].at("w"), 256);
  EXPECT_EQ(frames[1].at("h"), 192);
  EXPECT_EQ(frames[1].at("fl_x"), 4.0 * scene.sensors[1].fx);
  EXPECT_EQ(frames[1].at("cy"), 4.0 * scene.sensors[1].cy);
  EXPECT_EQ(Count(renderer::ReadWholeFile(folder.path() / "cameras/cameras.txt"), " 256 192 "), 1);
}

TEST(ExportResult, AConstantColourIsAFactorInGlbAndVertexColoursInPly) {
  const TemporaryFolder folder("export_constant");
  const optim::ObservationSet set = MakeObservations(1, 64, 48);
  renderer::Scene scene = MakeScene(set);
  scene.materials[0].vertex_colors = false;
  scene.materials[0].base_color = {0.1, 0.2, 0.3};
  ExportResult(folder.path(), scene, Views(set), {});
  const std::string glb = renderer::ReadWholeFile(folder.path() / "axe.glb");
  EXPECT_EQ(Count(glb, "COLOR_0"), 0);
  EXPECT_EQ(Count(glb, "baseColorFactor"), 1);
  EXPECT_NEAR(renderer::ReadMesh(folder.path() / "axe.ply").colors.at(0).b, 0.3, 5e-3);
}

/// JSON and binary chunks of a GLB.
std::pair<nlohmann::json, std::string> GlbChunks(const fs::path& path) {
  const std::string bytes = renderer::ReadWholeFile(path);
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, 4);
  return {nlohmann::json::parse(bytes.substr(20, size)), bytes.substr(28 + size)};
}

TEST(ExportResult, ABaseColourTextureIsInTheGlbAndBesideThePly) {
  const TemporaryFolder folder("export_texture");
  const optim::ObservationSet set = MakeObservations(1, 64, 48);
  renderer::Scene scene = MakeScene(set);
  scene.meshes[0].mesh = renderer::MakeRectangle();
  scene.textures = {
      {"other", 1, 1, {{1.0, 0.0, 0.0}}},
      {"paint", 2, 2, {{0.1, 0.2, 0.3}, {0.9, 0.5, 0.0}, {0.4, 0.4, 0.4}, {1.5, 1.0, 0.7}}}};
  renderer::Material& material = scene.materials[0];
  material.vertex_colors = false;
  material.base_color = {0.5, 0.5, 0.5};  // not used with a texture
  material.base_color_texture = 1;
  ExportResult(folder.path(), scene, Views(set), {});

  const auto [json, binary] = GlbChunks(folder.path() / "axe.glb");
  const nlohmann::json& pbr = json.at("materials")[0].at("pbrMetallicRoughness");
  const nlohmann::json& texture =
      json.at("textures").at(pbr.at("baseColorTexture").at("index").get<std::size_t>());
  const nlohmann::json& image = json.at("images").at(texture.at("source").get<std::size_t>());
  const nlohmann::json& view = json.at("bufferViews").at(image.at("bufferView").get<std::size_t>());
  EXPECT_EQ(pbr.value("baseColorFactor", std::vector<double>(4, 1.0)), std::vector<double>(4, 1.0));
  EXPECT_TRUE(json.at("meshes")[0].at("primitives")[0].at("attributes").contains("TEXCOORD_0"));
  renderer::WriteFileAtomically(folder.path() / "embedded.png",
                                binary.substr(view.at("byteOffset"), view.at("byteLength")));
  for (const char* file : {"embedded.png", "axe.png"}) {
    const renderer::Texture read =
        renderer::ReadTexture(folder.path() / file, renderer::TextureRole::kColor);
    ASSERT_EQ(read.texels.size(), 4U) << file;
    for (std::size_t i = 0; i < 4; ++i) {
      for (int c = 0; c < 3; ++c) {
        // Half a step of 8 bits on the sRGB curve, whose slope is at most 2.28.
        EXPECT_NEAR(
            read.texels[i][c], std::min(scene.textures[1].texels[i][c], 1.0), 2.28 * 0.5 / 255.0)
            << file;
      }
    }
  }
  const std::string ply = renderer::ReadWholeFile(folder.path() / "axe.ply");
  EXPECT_EQ(Count(ply, "comment TextureFile axe.png\n"), 1);
  EXPECT_EQ(Count(ply, "property float s\nproperty float t\n"), 1);
  EXPECT_EQ(renderer::ReadMesh(folder.path() / "axe.ply").uv_triangles.size(), 2U);
  EXPECT_EQ(renderer::ReadExr(folder.path() / "textures/paint.exr").ColorAt(1, 1).r, 1.5);
}

TEST(ExportResult, AGltfMaterialStaysOne) {
  const TemporaryFolder folder("export_gltf");
  const optim::ObservationSet set = MakeObservations(1, 64, 48);
  renderer::Scene scene = MakeScene(set);
  scene.meshes[0].mesh = renderer::MakeRectangle();
  const auto number = [](double value) { return renderer::Rgb::Constant(value / 255.0); };
  scene.textures = {{"paint", 1, 1, {{0.0, 1.0, 0.0}}},
                    {"map-roughness", 2, 1, {number(51), number(255)}},
                    {"map-metallic", 2, 1, {number(0), number(102)}},
                    {"glow", 1, 2, {{0.0, 0.0, 0.0}, {4.0, 4.0, 0.0}}}};
  scene.textures[1].scalar = scene.textures[2].scalar = true;
  renderer::Material& material = scene.materials[0];
  material.bsdf = renderer::MetallicRoughnessBsdf{};
  material.vertex_colors = false;
  material.base_color_texture = 0;
  material.roughness_texture = 1;
  material.metallic_texture = 2;
  scene.emitters.push_back({.name = "shine", .light = renderer::AreaEmitter{0, {3, 2, 1}, 3}});
  ExportResult(folder.path(), scene, Views(set), {});
  const renderer::Scene read = renderer::ReadGltf(folder.path() / "axe.glb").scene;
  EXPECT_EQ(read.meshes.at(0).name, "axe");
  EXPECT_EQ(read.materials.at(0).name, material.name);
  ASSERT_EQ(read.textures.size(), scene.textures.size());
  for (renderer::Rgb& texel : scene.textures[3].texels) texel *= 0.25;  // pictures end at 1
  for (std::size_t i = 0; i < read.textures.size(); ++i) {
    EXPECT_EQ(read.textures[i].name, scene.textures[i].name);
    EXPECT_EQ(read.textures[i].width, scene.textures[i].width);
    ASSERT_EQ(read.textures[i].texels.size(), scene.textures[i].texels.size());
    for (std::size_t k = 0; k < read.textures[i].texels.size(); ++k) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(read.textures[i].texels[k][c], scene.textures[i].texels[k][c], 1e-6);
      }
    }
  }
  const auto& light = std::get<renderer::AreaEmitter>(read.emitters.at(0).light);
  EXPECT_NEAR(light.intensity.g, 4.0 * 2.0, 1e-6);
}

/// PSNR of the pixels that show something, in sRGB values: what people compare.
double Psnr(const renderer::Scene& a, const renderer::Scene& b) {
  double squares = 0.0;
  double count = 0.0;
  const renderer::Renderer of_a(a), of_b(b);
  for (std::size_t v = 0; v < a.sensors.size(); ++v) {
    renderer::RenderOptions options;
    options.spp = 16;
    options.view = v;
    const renderer::Film first = of_a.RenderPrimal(a.sensors[v], options);
    const renderer::Film second = of_b.RenderPrimal(a.sensors[v], options);
    for (std::size_t i = 0; i < first.pixels.size(); ++i) {
      if (first.pixels[i].a == 0.0) continue;
      const double difference[] = {first.pixels[i].r - second.pixels[i].r,
                                   first.pixels[i].g - second.pixels[i].g,
                                   first.pixels[i].b - second.pixels[i].b};
      for (const double d : difference) squares += d * d;
      count += 3.0;
    }
  }
  return -10.0 * std::log10(squares / count);
}

/// A ball whose colours and, unless it is matt, roughness and metallic are textures on an atlas.
renderer::Scene TexturedBall(bool matt) {
  renderer::Scene scene = tests::BallScene(4, 5, 96);
  tests::Bump(scene);
  renderer::Mesh& ball = scene.meshes[0].mesh;
  for (std::size_t i = 0; i < ball.positions.size(); ++i) {
    const renderer::Vec3 p = std::as_const(ball).positions[i];
    ball.colors[i] = {0.5 + 0.3 * std::sin(5.0 * p.x), 0.4 + 0.3 * std::cos(4.0 * p.y), 0.3};
  }
  const optim::ObservationSet photos = tests::Photograph(scene, 1);
  std::vector<optim::UnknownSpec> unknowns;
  std::vector<int> free;
  const auto promote = [&](renderer::ParameterKind property, const std::string& name) {
    optim::UnknownSpec& unknown = unknowns.emplace_back();
    unknown.kind = renderer::ParameterKind::kTextureTexels;
    unknown.object = static_cast<int>(scene.textures.size());
    unknown.promotion = optim::Promotion{property, 0};
    free.push_back(unknown.object);
    scene.textures.push_back({name});
    scene.textures.back().scalar = property != renderer::ParameterKind::kBaseColor;
  };
  promote(renderer::ParameterKind::kBaseColor, "paint_base_color");
  if (!matt) {
    scene.materials[0].bsdf = renderer::MetallicRoughnessBsdf{0.4, 0.2};
    promote(renderer::ParameterKind::kRoughness, "paint_roughness");
    promote(renderer::ParameterKind::kMetallic, "paint_metallic");
  }
  scene =
      optim::PromoteSurfaces(scene, scene, unknowns, free, optim::MakeFitViews(photos, 1.0), 1.0)
          .scene;
  for (std::size_t t = 1; t < scene.textures.size(); ++t) {
    std::vector<renderer::Rgb>& texels = scene.textures[t].texels.Edit();
    for (std::size_t i = 0; i < texels.size(); ++i) {
      texels[i] = renderer::Rgb::Constant(0.3 + 0.2 * std::sin(0.01 * static_cast<double>(i)));
    }
  }
  return scene;
}

constexpr double kSamePicture = 45.0;  // dB

TEST(ExportResult, ATexturedGlbIsRenderedAsTheFitWas) {
  for (const bool matt : {true, false}) {
    const TemporaryFolder folder("export_same");
    renderer::Scene scene = TexturedBall(matt);
    const std::vector<fs::path> files = WriteMeshes(folder.path(), scene, MeshFormat::kGlb);
    ASSERT_EQ(files.size(), 1U);
    renderer::SceneFile read = renderer::ReadGltf(files[0]);
    EXPECT_TRUE(read.warnings.empty());
    ASSERT_EQ(read.scene.textures.size(), scene.textures.size());
    for (std::size_t t = 0; t < scene.textures.size(); ++t) {
      EXPECT_EQ(read.scene.textures[t].width, scene.textures[t].width);
    }
    read.scene.emitters = scene.emitters;
    const auto& bsdf = std::get<renderer::MetallicRoughnessBsdf>(read.scene.materials[0].bsdf);
    if (matt) {
      // What is matt here is so in glTF's model, too, whose samples are others.
      EXPECT_EQ(bsdf.metallic, 0.0);
      EXPECT_EQ(bsdf.specular, 0.0);
      scene.materials[0].bsdf = bsdf;
    }
    read.scene.environment_visible = scene.environment_visible;
    EXPECT_GT(Psnr(scene, read.scene), kSamePicture) << (matt ? "matt" : "glossy");
  }
}

/// With a normal texture of soft bumps.
renderer::Scene BumpyBall() {
  renderer::Scene scene = TexturedBall(false);
  renderer::ComputeVertexNormals(scene.meshes[0].mesh);
  renderer::Texture& bumps = scene.textures.emplace_back();
  bumps.name = "bumps";
  bumps.width = bumps.height = 32;
  bumps.texels.clear();
  for (int i = 0; i < 32 * 32; ++i) {
    const double x = 0.5 + 0.1 * std::sin(0.4 * (i % 32)), y = 0.5 + 0.1 * std::sin(0.03 * i);
    bumps.texels.push_back({std::round(255.0 * x) / 255.0, std::round(255.0 * y) / 255.0, 1.0});
  }
  scene.materials[0].normal_texture = static_cast<int>(scene.textures.size()) - 1;
  scene.materials[0].normal_scale = 1.5;
  return scene;
}

TEST(ExportResult, ANormalTextureStaysInTheGlb) {
  const TemporaryFolder folder("export_normals");
  const renderer::Scene scene = BumpyBall();
  renderer::SceneFile read =
      renderer::ReadGltf(WriteMeshes(folder.path(), scene, MeshFormat::kGlb).at(0));
  EXPECT_TRUE(read.warnings.empty());
  const renderer::Material& material = read.scene.materials.at(0);
  ASSERT_GE(material.normal_texture, 0);
  EXPECT_EQ(material.normal_scale, 1.5);
  const renderer::Texture& bumps =
      read.scene.textures[static_cast<std::size_t>(material.normal_texture)];
  EXPECT_EQ(bumps.name, "bumps");
  for (std::size_t i = 0; i < bumps.texels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(bumps.texels[i][c], scene.textures.back().texels[i][c], 1e-7);
    }
  }
  read.scene.emitters = scene.emitters;
  read.scene.environment_visible = scene.environment_visible;
  EXPECT_GT(Psnr(scene, read.scene), kSamePicture);
  read.scene.materials[0].normal_texture = -1;
  EXPECT_LT(Psnr(scene, read.scene), kSamePicture - 10.0);
}

TEST(ExportResult, ACoarseAssetIsNearerToTheFineOneByItsNormals) {
  const TemporaryFolder folder("export_coarse");
  const renderer::Scene fine = BumpyBall();
  const CoarseAsset asset = MakeCoarseAsset(fine, 600);
  renderer::SceneFile read =
      renderer::ReadGltf(WriteMeshes(folder.path(), asset.scene, MeshFormat::kGlb).at(0));
  read.scene.emitters = fine.emitters;
  read.scene.environment_visible = fine.environment_visible;
  ASSERT_LE(read.scene.meshes.at(0).mesh.triangles.size(), 600U);
  const double with = Psnr(fine, read.scene);
  ASSERT_GE(read.scene.materials.at(0).normal_texture, 0);
  read.scene.materials[0].normal_texture = -1;
  const double without = Psnr(fine, read.scene);
  RecordProperty("with_db", std::to_string(with));
  RecordProperty("without_db", std::to_string(without));
  EXPECT_GT(with, without + 1.0);
}

TEST(ExportResult, OneGlbHoldsAllMeshesAndEachPictureOnce) {
  const TemporaryFolder folder("export_scene");
  renderer::Scene scene = BumpyBall();
  scene.meshes.push_back(scene.meshes[0]);
  scene.meshes[1].name = "scene";
  scene.meshes[1].pose.translation = {3.0, 0.0, 0.0};
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].name = "other";
  scene.materials[1].base_color_texture = -1;
  scene.materials[1].base_color = {0.25, 0.5, 0.75};
  scene.meshes.push_back(scene.meshes[0]);
  scene.meshes[2].name = "third";
  scene.meshes[2].material = 1;
  const fs::path path = WriteSceneGlb(folder.path(), scene, 0.5);
  EXPECT_EQ(path.filename(), "scene-all.glb");
  const renderer::Scene read = renderer::ReadGltf(path).scene;
  ASSERT_EQ(read.meshes.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.meshes[i].name, scene.meshes[i].name);
    EXPECT_EQ(read.meshes[i].material, scene.meshes[i].material);
  }
  EXPECT_NEAR(read.meshes[1].mesh.positions[0].x - read.meshes[0].mesh.positions[0].x, 3.0, 1e-6);
  ASSERT_EQ(read.materials.size(), 2U);
  EXPECT_EQ(read.materials[1].name, "other");
  EXPECT_NEAR(read.materials[1].base_color.g, 0.5, 1e-7);
  EXPECT_EQ(read.materials[1].normal_texture, read.materials[0].normal_texture);
  EXPECT_EQ(read.materials[1].roughness_texture, read.materials[0].roughness_texture);
  EXPECT_EQ(read.textures.size(), scene.textures.size());
}

TEST(ExportResult, ObjNamesThePicturesOfRoughnessMetallicAndNormals) {
  const TemporaryFolder folder("export_obj_maps");
  const renderer::Scene scene = BumpyBall();
  const std::vector<fs::path> files = WriteMeshes(folder.path(), scene, MeshFormat::kObj);
  ASSERT_EQ(files.size(), 6U);
  const std::string stem = files[0].stem().string();
  const std::string mtl = renderer::ReadWholeFile(files[1]);
  for (const std::string& line : {"map_Kd " + stem + ".png\n",
                                  "map_Pr " + stem + "_roughness.png\n",
                                  "map_Pm " + stem + "_metallic.png\n",
                                  "norm -bm 1.5 " + stem + "_normal.png\n"}) {
    EXPECT_NE(mtl.find(line), std::string::npos) << line;
  }
  const renderer::Texture roughness = renderer::ReadTexture(files[3], renderer::TextureRole::kData);
  const renderer::Texture& expected =
      scene.textures[static_cast<std::size_t>(scene.materials[0].roughness_texture)];
  ASSERT_EQ(roughness.texels.size(), expected.texels.size());
  EXPECT_NEAR(roughness.texels[7].r, expected.texels[7].r, 0.5 / 255.0);
}

TEST(ExportResult, ATexturedObjAndPlyAreRenderedAsTheFitWas) {
  const TemporaryFolder folder("export_same_obj");
  const renderer::Scene scene = TexturedBall(true);
  for (const MeshFormat format : {MeshFormat::kObj, MeshFormat::kPly}) {
    const std::vector<fs::path> files = WriteMeshes(folder.path(), scene, format);
    renderer::Scene read = scene;
    read.meshes[0].mesh = renderer::ReadMesh(files.front());
    ASSERT_EQ(files.back().extension(), ".png");
    read.textures[0] = renderer::ReadTexture(files.back(), renderer::TextureRole::kColor);
    EXPECT_GT(Psnr(scene, read), kSamePicture) << files.front();
  }
}

TEST(ExportResult, MarksWhatNoPhotoShows) {
  const TemporaryFolder folder("export_seen");
  const renderer::Scene scene = TexturedBall(true);
  optim::ObservationSet photos = tests::Photograph(scene, 1);
  for (std::size_t v = 1; v < photos.views.size(); ++v) photos.views[v].validation = true;
  optim::FitSpec fit;
  fit.stages.resize(1);
  fit.unknowns.resize(1);
  fit.unknowns[0].kind = renderer::ParameterKind::kTextureTexels;
  fit.unknowns[0].promotion = optim::Promotion{};
  WriteTexelSights(folder.path(), scene, fit, photos);
  const renderer::Image marks =
      renderer::ReadImageFile(folder.path() / "textures/paint_base_color_seen.png", false).image;
  ASSERT_EQ(marks.width, scene.textures[0].width);
  std::array<int, 3> counts{};
  for (std::size_t i = 0; i < marks.data.size(); i += static_cast<std::size_t>(marks.channels)) {
    const double value = static_cast<double>(marks.data[i]);
    ++counts.at(value > 0.9 ? 2 : value > 0.1 ? 1 : 0);
  }
  // One photo shows less than half of a ball.
  EXPECT_GT(counts[2], counts[1] / 8);
  EXPECT_GT(counts[1], counts[2]);
  EXPECT_GT(counts[0], 0);
}

TEST(ExportResult, WritesWhatMovedAndEveryKindOfLight) {
  const TemporaryFolder folder("export_lights");
  const optim::ObservationSet set = MakeObservations(1, 64, 48);
  renderer::Scene scene = MakeScene(set);
  scene.meshes[0].pose.translation = {0.0, 0.0, 7.0};
  scene.textures = {{"slide", 2, 1, {{1, 2, 3}, {4, 5, 6}}}};
  renderer::SpotEmitter spot;
  renderer::ProjectorEmitter projector;
  projector.texture = 0;
  renderer::AreaEmitter area;
  area.mesh = 0;
  const renderer::Vec3 half_turn{0.0, std::numbers::pi, 0.0};
  scene.emitters = {
      {"spot", {}, half_turn, spot}, {"beamer", {}, {}, projector}, {"glow", {}, {}, area}};
  ExportResult(folder.path(), scene, Views(set), {});
  const double z = scene.meshes[0].mesh.positions[0].z;
  EXPECT_NEAR(renderer::ReadMesh(folder.path() / "axe.ply").positions[0].z, z + 7.0, 1e-5);
  EXPECT_EQ(renderer::ReadExr(folder.path() / "textures" / "slide.exr").ColorAt(1, 0).b, 6.0);
  const auto file = nlohmann::json::parse(renderer::ReadWholeFile(folder.path() / "lights.json"));
  const auto& lights = file.at("lights");
  EXPECT_EQ(lights[0].at("type"), "spot");
  EXPECT_NEAR(lights[0].at("direction")[2].get<double>(), 1.0, 1e-12) << "turned round";
  EXPECT_EQ(lights[1].at("texture"), "slide");
  EXPECT_EQ(lights[2].at("mesh"), "axe");
  EXPECT_TRUE(lights[2].at("texture").is_null());
}

TEST(ParameterTable, CamerasAreAGroupAndPlacesHaveComponents) {
  const optim::ObservationSet set = MakeObservations(3, 64, 48);
  const renderer::Scene start = MakeScene(set);
  renderer::Scene result = start;
  for (renderer::Camera& sensor : result.sensors) sensor.world_from_camera.translation.x += 0.1;
  optim::FitSpec spec;
  spec.unknowns.resize(2);
  spec.unknowns[0].name = "camera.position";
  spec.unknowns[0].kind = renderer::ParameterKind::kCameraPosition;
  spec.unknowns[0].object = -1;
  spec.unknowns[1].name = "axe.translation";
  spec.unknowns[1].kind = renderer::ParameterKind::kObjectTranslation;
  const std::vector<ParameterSummary> rows = SummarizeParameters(spec, start, result);
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0].name, "camera.position");
  EXPECT_EQ(rows[0].num_scalars, 9);
  EXPECT_NEAR(rows[0].rms_change, 0.1 / std::sqrt(3.0), 1e-12);
  EXPECT_TRUE(std::isnan(rows[0].value)) << "a mean of places says nothing";
  EXPECT_EQ(rows[3].name, "axe.translation.z");
  EXPECT_EQ(rows[3].unit, "m");
}

TEST(ParameterTable, ALensOfAllPhotosHasItsNumbersOnce) {
  const renderer::Scene start = MakeScene(MakeObservations(3, 64, 48));
  renderer::Scene result = start;
  for (Camera& sensor : result.sensors) sensor.vignetting = {-0.25, 0.125, 0.5};
  optim::FitSpec spec;
  spec.unknowns.resize(1);
  spec.unknowns[0].name = "camera.vignetting";
  spec.unknowns[0].kind = renderer::ParameterKind::kVignetting;
  spec.unknowns[0].object = -1;
  spec.unknowns[0].sharing = {0, 0, 0};
  const std::vector<ParameterSummary> rows =
      SummarizeParameters(spec, start, result, {{"camera.vignetting", {0.01, 0.02, 0.03}}});
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[1].name, "camera.vignetting.2");
  EXPECT_EQ(rows[1].num_scalars, 1);
  EXPECT_EQ(rows[1].initial, 0.0);
  EXPECT_EQ(rows[1].value, 0.125);
  EXPECT_EQ(rows[1].standard_error, 0.02);
  spec.unknowns[0].sharing = {0, 0, 2};
  const std::vector<ParameterSummary> lenses = SummarizeParameters(spec, start, result);
  ASSERT_EQ(lenses.size(), 1U) << "two lenses are a group";
  EXPECT_EQ(lenses[0].num_scalars, 6);
}

TEST(ParameterTable, HasScalarsAndGroups) {
  const optim::ObservationSet set = MakeObservations(5, 64, 48);
  const renderer::Scene start = MakeScene(set);
  renderer::Scene result = start;
  std::get<renderer::MetallicRoughnessBsdf>(result.materials[0].bsdf).roughness = 0.1;
  for (renderer::Vec3& p : result.meshes[0].mesh.positions) p.x += 0.01;
  const std::vector<ParameterSummary> rows = SummarizeParameters(MakeSpec(), start, result);
  ASSERT_EQ(rows.size(), 8U);
  EXPECT_EQ(rows[0].name, "axe.vertices");
  EXPECT_NEAR(rows[0].rms_change, 0.01 / std::sqrt(3.0), 1e-12);
  EXPECT_EQ(rows[1].name, "paint.roughness");
  EXPECT_EQ(rows[1].num_at_bound, 1);
  EXPECT_EQ(rows[1].initial, 0.4);
  EXPECT_TRUE(rows[2].held);
  EXPECT_EQ(rows[3].name, "room.intensity.r");
  EXPECT_EQ(rows[5].name, "room.intensity.b");
  EXPECT_EQ(rows[6].num_scalars, 16 * 8 * 3);
  EXPECT_EQ(rows[7].name, "exposure");
  EXPECT_EQ(rows[7].num_scalars, 5);
  EXPECT_EQ(rows[7].upper_bound, 8.0);
}

TEST(ParameterTable, CountsWhatNoPhotoTellsAndHasErrorsOfGains) {
  const optim::ObservationSet set = MakeObservations(3, 64, 48);
  const renderer::Scene scene = MakeScene(set);
  constexpr double kUntold = std::numeric_limits<double>::infinity();
  constexpr double kTold = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> texels(16 * 8 * 3, kTold);
  texels[7] = texels[8] = kUntold;
  const StandardErrorsByName errors = {{"paint.roughness", {kUntold}},
                                       {"room.intensity", {0.5, 0.25, kUntold}},
                                       {"room.texels", texels},
                                       {"axe.vertices", {kUntold}},  // of another mesh
                                       {"IMG_0001.jpg.exposure", {0.125}},
                                       {"IMG_0002.jpg.exposure", {kUntold}}};
  const std::vector<ParameterSummary> rows = SummarizeParameters(MakeSpec(), scene, scene, errors);
  ASSERT_EQ(rows.size(), 8U);
  EXPECT_EQ(rows[0].num_undetermined, 0);
  EXPECT_EQ(rows[1].num_undetermined, 1);
  EXPECT_EQ(rows[3].standard_error, 0.5);
  EXPECT_EQ(rows[3].num_undetermined, 0);
  EXPECT_EQ(rows[5].num_undetermined, 1);
  EXPECT_EQ(rows[6].num_undetermined, 2);
  EXPECT_TRUE(std::isnan(rows[6].standard_error));
  EXPECT_EQ(rows[7].num_undetermined, 1);
  EXPECT_EQ(rows[7].standard_error, 0.125) << "the median of those known";
  const std::vector<double> gains = GainErrors(scene, errors);
  ASSERT_EQ(gains.size(), 3U);
  EXPECT_TRUE(std::isnan(gains[0])) << "held out";
  EXPECT_EQ(gains[1], 0.125);
  EXPECT_EQ(gains[2], kUntold);
}

}  // namespace
}  // namespace pathfit::app::export_result_test
