#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/renderer/known_answers/known_answer.h"

// Image form and material form split a derivative differently; their totals agree in every part of
// the image, in every pixel where that is sharp enough. Scenes of many kinds, all terms at once.
namespace pathfit::tests::forms_agree_test {
namespace {

using renderer::DerivativeForm;
using renderer::Mesh;
using renderer::ParameterKind;
using renderer::PixelFilter;
using renderer::Rgb;

constexpr int kReplicates = 32;  // t and normal distribution differ by 2 % of the rms
constexpr int kSize = 16;
constexpr int kPixel = 1, kTile = 2;  // sides of what is compared
constexpr double kDark = 1e-6;        // radiance per unit of motion

/// Estimates of the derivative, mean of the colours, by tile and replicate.
std::vector<std::vector<double>> Tiles(const renderer::Renderer& renderer,
                                       const Motion& motion,
                                       renderer::RenderOptions options,
                                       DerivativeForm form,
                                       int tile,
                                       int replicates) {
  const renderer::Camera& camera = renderer.scene().sensors[0];
  options.form = form;
  const int per_side = kSize / tile;
  std::vector<std::vector<double>> tiles(static_cast<std::size_t>(per_side * per_side));
  for (int i = 0; i < replicates; ++i) {
    options.seed = static_cast<std::uint64_t>(i) + (form == DerivativeForm::kImage ? 0 : 1000);
    renderer::FilmSink sink(motion.layout, motion.direction, camera.width, camera.height);
    renderer.RenderDerivative(camera, 0, options, motion.layout, sink);
    std::vector<double> sums(tiles.size());
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const renderer::Rgba& p = sink.film().pixels[static_cast<std::size_t>(y * kSize + x)];
        sums[static_cast<std::size_t>(y / tile * per_side + x / tile)] += (p.r + p.g + p.b) / 3.0;
      }
    }
    for (std::size_t t = 0; t < tiles.size(); ++t) tiles[t].push_back(sums[t]);
  }
  return tiles;
}

void ExpectFormsAgree(const renderer::Scene& scene,
                      const Motion& motion,
                      const renderer::RenderOptions& options,
                      int tile = kTile,
                      int replicates = kReplicates) {
  const renderer::Renderer renderer(scene);
  const auto image = Tiles(renderer, motion, options, DerivativeForm::kImage, tile, replicates);
  const auto material =
      Tiles(renderer, motion, options, DerivativeForm::kMaterial, tile, replicates);
  double sum_z2 = 0.0;
  double largest = 0.0;
  std::vector<double> sharpness;
  for (std::size_t t = 0; t < image.size(); ++t) {
    const MeanAndError a = EstimateMean(image[t]);
    const MeanAndError b = EstimateMean(material[t]);
    const double error = std::hypot(a.error, b.error);
    if (error < kDark) {  // nothing moves there, or hardly a filter's rim sees it
      EXPECT_NEAR(a.mean, b.mean, 10.0 * kDark) << "tile " << t;
      continue;
    }
    const double z = (a.mean - b.mean) / error;
    sum_z2 += z * z;
    largest = std::max(largest, std::abs(z));
    sharpness.push_back(std::abs(b.mean) / error);
  }
  ASSERT_FALSE(sharpness.empty());
  const double rms = std::sqrt(sum_z2 / static_cast<double>(sharpness.size()));
  // The median: in image form a concave corner has an interior term of infinite variance.
  const auto middle = sharpness.begin() + static_cast<std::ptrdiff_t>(sharpness.size() / 2);
  std::nth_element(sharpness.begin(), middle, sharpness.end());
  ::testing::Test::RecordProperty("z_rms", std::to_string(rms));
  ::testing::Test::RecordProperty("z_largest", std::to_string(largest));
  ::testing::Test::RecordProperty("signal_to_noise", std::to_string(*middle));
  EXPECT_LT(rms, 1.1);
  EXPECT_LT(largest, 4.5);
  EXPECT_GT(*middle, 10.0);  // the test could tell
}

/// `share`: of the usual samples, fewer where they tell enough.
renderer::RenderOptions Options(int bounces, double share = 1.0) {
  renderer::RenderOptions options;
  options.max_bounces = bounces;
  options.spp = static_cast<int>(64 * share);
  options.sppe = options.spp_pixel = 64 * share;
  options.spp_direct = options.spp_indirect = 128 * share;
  return options;
}

Mesh Placed(Mesh mesh, double scale, const Vec3& turn, const Vec3& centre) {
  for (Vec3& p : mesh.positions) p = p * scale;
  renderer::ApplyTransform({renderer::RotationFromVector(turn), centre}, mesh);
  return mesh;
}
renderer::Camera Sensor(const Vec3& eye, const Vec3& target, double focal) {
  renderer::Camera camera = CameraAt(eye, target, focal, kSize, kSize);
  camera.world_from_camera = renderer::LookAt(eye, target, {0, 0, 1});
  return camera;
}

TEST(FormsAgree, SoftShadow) {
  FloorScene s(3.0);
  s.AddLight(Ceiling(-0.5, 0.6, -0.4, 0.5, 2.5), 3.0);
  s.scene.materials.push_back({"clay", renderer::LambertBsdf{}, {0.7, 0.5, 0.3}});
  const int cube = s.Add("cube", Placed(Cube(), 0.3, {0.3, 0.4, 0.2}, {0.1, -0.1, 0.8}), 2);
  s.scene.meshes[static_cast<std::size_t>(cube)].pose.pivot = {0.1, -0.1, 0.8};
  s.scene.sensors = {Sensor({1.8, -2.0, 2.4}, {0.1, 0.0, 0.3}, 14.0)};
  ExpectFormsAgree(s.scene,
                   Motion(s.scene)
                       .Add(ParameterKind::kObjectTranslation, cube, Vec3{0.3, 0.2, 0.4})
                       .Add(ParameterKind::kObjectRotation, cube, Vec3{0.5, -0.4, 0.3})
                       .Vertices(0,
                                 [](const Vec3& p) {
                                   return Vec3{0.2, 0.1, 0.1 * p.x - 0.1 * p.y};
                                 })
                       .Vertices(1,
                                 [](const Vec3& p) {
                                   return Vec3{0.3 * p.y, 0.2, -0.4};
                                 }),
                   Options(1, 0.25),
                   kPixel);
}

TEST(FormsAgree, MeshOnAFloorUnderASkyWithTwoBounces) {
  FloorScene s(2.0);
  s.scene.materials[0].base_color = {0.6, 0.7, 0.8};
  s.scene.materials.push_back({"clay", renderer::LambertBsdf{}, {0.8, 0.6, 0.4}});
  const int ball = s.Add("ball", Placed(renderer::MakeIcosphere(1, 0.5), 1.0, {}, {0, 0, 0.6}), 2);
  s.scene.emitters = {GradientEnvironment(8, 4)};
  renderer::Camera camera = Sensor({1.4, -1.8, 1.5}, {0.0, 0.0, 0.4}, 14.0);
  camera.filter = {PixelFilter::Shape::kTent, 1.0, 0.5};
  s.scene.sensors = {camera};
  renderer::RenderOptions options = Options(2);
  options.spp = 256;
  ExpectFormsAgree(s.scene,
                   Motion(s.scene)
                       .Vertices(ball,
                                 [](const Vec3& p) {
                                   return Vec3{0.4 + 0.3 * p.z, 0.3 * p.x, 0.5 * p.y - 0.2};
                                 })
                       .Add(ParameterKind::kLightRotation, 0, Vec3{0.3, 0.5, -0.2}),
                   options);
}

TEST(FormsAgree, GlossyFloor) {
  FloorScene s(2.0);
  s.scene.materials[0] = {"gloss", renderer::MetallicRoughnessBsdf{0.6, 0.7}, {0.8, 0.7, 0.5}};
  s.scene.materials.push_back({"clay", renderer::LambertBsdf{}, {0.7, 0.5, 0.3}});
  s.AddLight(Placed(Ceiling(-0.6, 0.6, -0.5, 0.5, 0.0), 1.0, {-0.6, 0, 0}, {0, 1.4, 1.2}), 4.0);
  const int cube = s.Add("cube", Placed(Cube(), 0.25, {0.2, 0.3, 0.5}, {0.1, 0.3, 0.5}), 2);
  renderer::Camera camera = Sensor({0.2, -2.2, 1.4}, {0.0, 0.2, 0.1}, 15.0);
  camera.filter = {PixelFilter::Shape::kGaussian, 1.5, 0.5};
  s.scene.sensors = {camera};
  renderer::RenderOptions options = Options(1, 0.5);
  options.spp = 128;  // the filter's slope times a glossy lobe
  ExpectFormsAgree(s.scene,
                   Motion(s.scene)
                       .Vertices(0,
                                 [](const Vec3& p) {
                                   return Vec3{0.1, 0.2, 0.1 * p.x + 0.2 * p.y};
                                 })
                       .Add(ParameterKind::kObjectTranslation, cube, Vec3{0.3, 0.2, 0.1}),
                   options,
                   kPixel);
}

TEST(FormsAgree, TexturedPlaneUnderAProjector) {
  FloorScene s(1.5);
  renderer::Scene& scene = s.scene;
  renderer::Texture paint{"paint", 4, 4, {}, renderer::TextureWrap::kClamp, false};
  renderer::Texture slide{"slide", 4, 4, {}, renderer::TextureWrap::kClamp, false};
  for (int i = 0; i < 16; ++i) {
    paint.texels.push_back(
        {0.5 + 0.3 * std::sin(i), 0.5 + 0.3 * std::cos(2.0 * i), 0.4 + 0.2 * std::sin(3.0 * i)});
    slide.texels.push_back(
        {0.6 + 0.3 * std::cos(i), 0.6 + 0.3 * std::sin(2.3 * i), 0.5 + 0.4 * std::cos(1.7 * i)});
  }
  // The picture fades to black: its border is no step.
  for (int i = 0; i < 16; ++i) {
    if (i % 4 == 0 || i % 4 == 3 || i < 4 || i >= 12)
      slide.texels[static_cast<std::size_t>(i)] = {};
  }
  scene.textures = {paint, slide};
  scene.materials[0].base_color_texture = 0;
  const Vec3 place{0.5, -0.4, 2.0};
  renderer::ProjectorEmitter projector;
  projector.position = place;
  projector.frame_from_light = renderer::LookAt(place, {0, 0, 0}, {0, 1, 0}).linear;
  projector.tan_half_width = projector.tan_half_height = 0.5;
  projector.intensity = Rgb::Constant(2.0);
  projector.texture = 1;
  scene.emitters = {{"projector", renderer::LightFrame::kWorld, {}, projector}};
  const int plate = s.Add("plate", Placed(Cube(), 0.15, {0.2, 0.5, 0.1}, {0.1, 0.1, 0.6}));
  scene.sensors = {Sensor({-1.0, -1.6, 1.8}, {0.0, 0.0, 0.1}, 17.0)};
  ExpectFormsAgree(scene,
                   Motion(scene)
                       .Vertices(0,
                                 [](const Vec3& p) {
                                   return Vec3{0.3, 0.2 * p.x, 0.1 * p.x + 0.2};
                                 })
                       .Add(ParameterKind::kObjectTranslation, plate, Vec3{0.2, -0.3, 0.1})
                       .Add(ParameterKind::kLightPosition, 0, Vec3{0.3, 0.2, -0.1})
                       .Add(ParameterKind::kLightRotation, 0, Vec3{0.1, -0.1, 0.2}),
                   Options(1),
                   kPixel);
}

TEST(FormsAgree, CameraInARoomWithTwoBounces) {
  FloorScene s;
  renderer::Scene& scene = s.scene;
  scene.meshes.clear();
  Mesh room = Placed(Cube(), 1.0, {}, {0, 0, 1});
  for (renderer::Triangle& t : room.triangles) std::swap(t[1], t[2]);
  scene.materials[0].base_color = {0.7, 0.6, 0.5};
  s.Add("room", room, 0);
  s.AddLight(Ceiling(-0.4, 0.4, -0.3, 0.3, 1.95), 5.0);
  s.Add("block", Placed(Cube(), 0.25, {0.1, 0.2, 0.5}, {0.2, 0.3, 0.6}), 0);
  scene.sensors = {Sensor({-0.3, -0.8, 1.1}, {0.1, 0.4, 0.8}, 12.0)};
  renderer::RenderOptions options = Options(2, 0.25);
  options.spp_pixel = 64;              // much crosses the pixels' borders, in and out
  constexpr int kManyReplicates = 96;  // corners: the mean of few is not normally distributed
  ExpectFormsAgree(scene,
                   Motion(scene)
                       .Add(ParameterKind::kCameraPosition, 0, Vec3{0.3, 0.1, -0.2})
                       .Add(ParameterKind::kCameraRotation, 0, Vec3{0.1, -0.2, 0.3})
                       .Add(ParameterKind::kFocal, 0, std::vector{1.0, 2.0}),
                   options,
                   kTile,
                   kManyReplicates);
}

// Each facet is hardly wider than the distance at which the others count as near: what the strips
// along its sides send out is a share that shows. The floor, which nobody sees, makes the scene
// large, and that distance with it.
TEST(FormsAgree, CameraInABallOfFacetsAboveALargeFloor) {
  FloorScene s(30.0);
  renderer::Scene& scene = s.scene;
  scene.materials.push_back({"clay", renderer::LambertBsdf{}, {0.7, 0.6, 0.5}});
  const Vec3 centre{0, 0, 1.5};
  const int ball = s.Add("ball", Placed(renderer::MakeIcosphere(2, 0.4), 1.0, {}, centre), 2);
  scene.emitters = {{"lamp",
                     renderer::LightFrame::kWorld,
                     {},
                     renderer::PointEmitter{{0.1, 0.1, 1.55}, {0.1, 0.1, 0.1}}}};
  scene.sensors = {Sensor({0.05, 0.02, 1.45}, {0.3, 0.5, 1.5}, 8.0)};
  ExpectFormsAgree(
      scene, Motion(scene).Vertices(ball, [&](const Vec3& p) { return p - centre; }), Options(2));
}

TEST(FormsAgree, SmoothMeshUnderASpot) {
  FloorScene s(2.0);
  renderer::Scene& scene = s.scene;
  Mesh ball = renderer::MakeIcosphere(1, 0.5);
  ball.normals = ball.positions;
  ball.normal_triangles = ball.triangles;
  for (Vec3& p : ball.positions) p += Vec3{0, 0, 0.8};
  scene.materials.push_back({"gloss", renderer::MetallicRoughnessBsdf{0.6, 0.2}, {0.7, 0.5, 0.4}});
  const int mesh = s.Add("ball", ball, 2);
  const Vec3 place{1.2, -1.0, 2.4};
  renderer::SpotEmitter spot;
  spot.position = place;
  spot.frame_from_light = renderer::LookAt(place, {0, 0, 0.5}, {0, 0, 1}).linear;
  spot.intensity = Rgb::Constant(8.0);
  spot.inner_angle = 0.15;
  spot.outer_angle = 0.5;
  scene.emitters = {{"spot", renderer::LightFrame::kWorld, {}, spot}};
  scene.sensors = {Sensor({-0.8, -2.2, 1.6}, {0.0, 0.0, 0.5}, 14.0)};
  Motion motion(scene);
  motion.Vertices(mesh,
                  [](const Vec3& p) {
                    return Vec3{0.3 + 0.2 * p.y, -0.2 * p.x, 0.1 * p.z};
                  })
      .Add(ParameterKind::kLightPosition, 0, Vec3{0.3, 0.2, -0.1})
      .Add(ParameterKind::kLightRotation, 0, Vec3{0.2, -0.1, 0.1})
      .Add(ParameterKind::kSpotAngles, 0, std::vector{0.1, 0.2});
  motion.layout.Add(ParameterKind::kVertexNormals, mesh);
  for (const Vec3& n : ball.normals) {
    motion.direction.insert(motion.direction.end(), {0.2 * n.y, -0.1 * n.z, 0.3 * n.x});
  }
  ExpectFormsAgree(scene, motion, Options(1), kPixel);
}

TEST(FormsAgree, NormalMap) {
  renderer::Scene scene = Waves();
  scene.emitters.push_back(GradientEnvironment(8, 4));
  scene.meshes.push_back({"cube", Placed(Cube(), 0.2, {0.3, 0.4, 0.2}, {0.2, -0.1, 0.6}), 1, {}});
  scene.materials.push_back({"clay", renderer::LambertBsdf{}, {0.7, 0.5, 0.3}});
  scene.sensors = {Sensor({0.4, -0.5, 3.0}, {0.0, 0.0, 0.0}, 16.0)};
  ExpectFormsAgree(scene,
                   Motion(scene)
                       .Add(ParameterKind::kObjectRotation, 0, Vec3{0.3, -0.2, 0.4})
                       .Vertices(0,
                                 [](const Vec3& p) {
                                   return Vec3{0.3 * p.y, 0.2 * p.x, 0.1 * p.x};
                                 })
                       .Add(ParameterKind::kCameraPosition, 0, Vec3{0.3, 0.2, 0.1}),
                   Options(2, 0.5));
}

}  // namespace
}  // namespace pathfit::tests::forms_agree_test
