#include "renderer/path/path_tracer.h"

#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/probe.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer::path_tracer_test {
namespace {

using tests::AgreesWithExact;
using tests::Channel;
constexpr double kPi = std::numbers::pi;
constexpr int kReplicates = 32;

RenderOptions Options(int spp, int max_bounces = 1) {
  RenderOptions options;
  options.spp = spp;
  options.max_bounces = max_bounces;
  return options;
}

std::vector<double> Radiance(const Scene& scene,
                             const Camera& camera,
                             const RenderOptions& options) {
  return Channel(tests::PrimalReplicates(Renderer(scene), camera, options, kReplicates), 0);
}

Scene WhiteMetalFloor(double alpha) {
  return tests::SceneOf(tests::Plate(1, 1, 0),
                        MetallicRoughnessBsdf{std::sqrt(alpha), 1.0},
                        {1, 1, 1},
                        {tests::ConstantEnvironment({1, 1, 1})});
}

/// A sky of one colour is drawn over the receiver's hemisphere only; what glass lets through comes
/// from the other one.
TEST(PathTracer, RoughGlassUnderAConstantSkyOfOneOrMoreTexels) {
  std::array<tests::MeanAndError, 2> means;
  for (const bool texels : {false, true}) {
    Scene scene = tests::SceneOf(tests::Plate(1, 1, 0),
                                 RoughDielectricBsdf{0.8, 1.5},
                                 {1, 1, 1},
                                 {tests::ConstantEnvironment({1, 1, 1})});
    if (texels) {
      auto& sky = std::get<EnvironmentEmitter>(scene.emitters[0].light);
      sky.width = sky.height = 2;
      sky.texels.assign(4, {1, 1, 1});
    }
    RenderOptions options = Options(4096);
    options.view = texels ? 1 : 0;
    means[texels ? 1 : 0] = tests::EstimateMean(
        Radiance(scene, tests::ProbeCamera({0.5, 0.3, 1.2}, {0, 0, 0}), options));
  }
  const double error = std::hypot(means[0].error, means[1].error);
  EXPECT_NEAR(means[0].mean, means[1].mean, 4.0 * error);
  EXPECT_LT(error, 2e-3);
}

// C20: GGX with F = 1 in a constant environment, normal incidence and 45 degrees (height-correlated
// Smith).
TEST(PathTracer, GgxUnderConstantEnvironment) {
  const Scene scene = WhiteMetalFloor(0.3);
  EXPECT_TRUE(AgreesWithExact(
      Radiance(scene, tests::ProbeCamera({0, 0, 2}, {0, 0, 0}), Options(4096)), 0.8773584157886));
  EXPECT_TRUE(AgreesWithExact(
      Radiance(scene, tests::ProbeCamera({0, 2, 2}, {0, 0, 0}), Options(4096)), 0.8453962137678));
}

// C21: environment L0 + k.w on fine texels, and the same map turned: E = pi L0 + (2 pi / 3) (R
// k).n.
TEST(PathTracer, LinearEnvironmentAndItsRotation) {
  constexpr double kMapError =
      2e-4;  // bilinear texels of 1.4 degrees flatten the function a little
  const Vec3 k{0.3, -0.2, 0.5};
  for (const double turn : {0.0, 0.7}) {
    Scene scene = tests::SceneOf(
        tests::Plate(1, 1, 0), LambertBsdf{}, {1, 1, 1}, {tests::LinearEnvironment(1.0, k)});
    const Mat3 rotation = RotationAboutAxis({1, 0, 0}, turn);
    std::get<EnvironmentEmitter>(scene.emitters[0].light).frame_from_light = rotation;
    const double irradiance = kPi + 2.0 * kPi / 3.0 * (rotation * k).z;
    if (turn == 0.0) {
      EXPECT_NEAR(irradiance, 4.188790204786, 1e-12);
    }
    EXPECT_TRUE(
        AgreesWithExact(Radiance(scene, tests::ProbeCamera({0.5, 1, 2}, {0, 0, 0}), Options(4096)),
                        irradiance / kPi,
                        0.01,
                        kMapError));
  }
}

// C22: half-bright environment tilted by theta: E = (pi / 2) (1 + cos theta).
TEST(PathTracer, HalfBrightEnvironment) {
  Scene scene = tests::SceneOf(
      tests::Plate(1, 1, 0), LambertBsdf{}, {1, 1, 1}, {tests::LinearEnvironment(1.0, {})});
  auto& environment = std::get<EnvironmentEmitter>(scene.emitters[0].light);
  for (std::size_t i = environment.texels.size() / 2; i < environment.texels.size(); ++i)
    environment.texels[i] = {};
  // The map's bright pole +y goes to +z turned by theta; the ramp of bilinear texels is odd about
  // the border.
  environment.frame_from_light = RotationAboutAxis({1, 0, 0}, 0.5 * kPi - 0.6);
  EXPECT_TRUE(
      AgreesWithExact(Radiance(scene, tests::ProbeCamera({0.5, 1, 2}, {0, 0, 0}), Options(4096)),
                      2.867230479068 / kPi));
}

// C23: black sphere above a floor point in a constant environment: E = pi (1 - R^2 c_z / |c|^3).
TEST(PathTracer, BlackSphereAboveAFloorPoint) {
  Scene scene = tests::SceneOf(
      tests::Plate(2, 2, 0), LambertBsdf{}, {1, 1, 1}, {tests::ConstantEnvironment({1, 1, 1})});
  // Fine enough that the mesh's smaller solid angle (3e-4 of its own) is far below the noise.
  Mesh ball = MakeIcosphere(5, 0.3);
  ApplyTransform({{}, {0.2, -0.1, 0.8}}, ball);
  scene.meshes.push_back({"ball", ball, 1});
  scene.materials.push_back({"black", LambertBsdf{}, {0, 0, 0}});
  EXPECT_TRUE(
      AgreesWithExact(Radiance(scene, tests::ProbeCamera({-2, 1.5, 1}, {0, 0, 0}), Options(2048)),
                      2.746945719694 / kPi));
}

// C25: light and camera at one point above a diffuse plane: L = (rho / pi) I cos(theta) / r^2,
// without noise.
TEST(PathTracer, CollocatedPointLight) {
  const Scene scene =
      tests::SceneOf(tests::Plate(3, 3, 0),
                     LambertBsdf{},
                     {0.6, 0.6, 0.6},
                     {{"flash", LightFrame::kCamera, {}, PointEmitter{{0, 0, 0}, {3, 3, 3}}}});
  const Camera camera = tests::ProbeCamera({0, 2 * std::sin(0.5), 2 * std::cos(0.5)}, {0, 0, 0});
  for (const double l : Radiance(scene, camera, Options(1)))
    EXPECT_NEAR(l, 1.257044424265e-01, 1e-9);
}

TEST(PathTracer, SunOnLambertWithoutNoise) {
  const Vec3 down = Normalized(Vec3{0.6, 0.2, -1.0});
  const Scene scene =
      tests::SceneOf(tests::Plate(1, 1, 0),
                     LambertBsdf{},
                     {0.5, 0.25, 1.0},
                     {{"sun", LightFrame::kWorld, {}, DirectionalEmitter{down, {2, 2, 2}}}});
  const Renderer renderer(scene);
  const Rgba pixel =
      renderer.RenderPrimal(tests::ProbeCamera({0, 1, 2}, {0, 0, 0}), Options(1)).pixels[0];
  EXPECT_NEAR(pixel.r, 0.5 / kPi * 2.0 * -down.z, 1e-12);
  EXPECT_NEAR(pixel.g, 0.25 / kPi * 2.0 * -down.z, 1e-12);
  EXPECT_EQ(pixel.a, 1.0);
}

// White furnace: a white convex body in a constant environment cannot be told from it, at any
// bounce count.
TEST(PathTracer, WhiteConvexBodiesVanishInTheFurnace) {
  for (const Mesh& body : {MakeIcosphere(2, 1.0), tests::Cube()}) {
    for (const int bounces : {1, 2, 5}) {
      const Scene scene =
          tests::SceneOf(body, LambertBsdf{}, {1, 1, 1}, {tests::ConstantEnvironment({1, 1, 1})});
      const Camera camera = tests::CameraAt({2, 2.5, 3}, {0, 0, 0}, 12.0, 8, 8);
      EXPECT_TRUE(AgreesWithExact(Radiance(scene, camera, Options(256, bounces)), 64.0, 0.001))
          << bounces;
    }
  }
}

TEST(PathTracer, WhiteCornerFillsUpWithBounces) {
  // Two white plates at right angles: light that misses the sky once finds it later, so radiance
  // tends to one.
  Scene scene = tests::SceneOf(
      tests::Plate(1, 1, 0), LambertBsdf{}, {1, 1, 1}, {tests::ConstantEnvironment({1, 1, 1})});
  Mesh side = tests::Plate(1, 1, 0);
  ApplyTransform({RotationAboutAxis({0, 1, 0}, -0.5 * kPi), {1, 0, 1}}, side);
  scene.meshes.push_back({"side", side, 0});
  const Camera camera = tests::ProbeCamera({-1, 0, 3}, {0.8, 0, 0});
  double previous = 0.0;
  for (const int bounces : {1, 2, 3, 40}) {
    const double radiance =
        tests::EstimateMean(Radiance(scene, camera, Options(1024, bounces))).mean;
    EXPECT_GT(radiance, previous);
    EXPECT_LT(radiance, 1.01);
    previous = radiance;
  }
  EXPECT_TRUE(AgreesWithExact(Radiance(scene, camera, Options(1024, 200)), 1.0, 0.003))
      << "roulette is unbiased";
}

// Closed sphere of albedo rho with a lamp in its centre: L_N = rho I / (pi R^2) (1 + rho + ... +
// rho^(N-1)).
TEST(PathTracer, BouncesInAClosedSphereFormAGeometricSeries) {
  constexpr double kMeshError = 5e-5;  // faces lie a little inside the sphere, unevenly
  const double rho = 0.7;
  const Scene scene =
      tests::SceneOf(MakeIcosphere(4, 1.0),
                     LambertBsdf{},
                     {rho, rho, rho},
                     {{"lamp", LightFrame::kWorld, {}, PointEmitter{{0, 0, 0}, {kPi, kPi, kPi}}}});
  const Camera camera = tests::CameraAt({0, 0, 0.2}, {0, 0, -1}, 2.0, 4, 4);
  const double direct = tests::EstimateMean(Radiance(scene, camera, Options(64, 1))).mean;
  EXPECT_NEAR(direct, 16.0 * rho, 16.0 * rho * 3e-3);
  double series = 1.0;
  double power = 1.0;
  for (int bounces = 2; bounces <= 4; ++bounces) {
    power *= rho;
    series += power;
    EXPECT_TRUE(AgreesWithExact(
        Radiance(scene, camera, Options(256, bounces)), direct * series, 0.003, kMeshError))
        << bounces;
  }
}

TEST(PathTracer, NoLightEntersAClosedBox) {
  const Scene scene = tests::SceneOf(
      tests::Cube(), LambertBsdf{}, {1, 1, 1}, {tests::ConstantEnvironment({1, 1, 1})});
  for (const double l :
       Radiance(scene, tests::CameraAt({0, 0, 0.5}, {0, 0, -1}, 4.0, 8, 8), Options(16, 4))) {
    EXPECT_EQ(l, 0.0);
  }
}

TEST(PathTracer, OneSidedMaterialsAreBlackFromBehindAndStillBlock) {
  Scene scene = tests::SceneOf(
      tests::Plate(1, 1, 0), LambertBsdf{}, {1, 1, 1}, {tests::ConstantEnvironment({1, 1, 1})});
  const Camera behind = tests::ProbeCamera({0, 0, -2}, {0, 0, 0});
  EXPECT_TRUE(AgreesWithExact(Radiance(scene, behind, Options(256)), 1.0));
  scene.materials[0].two_sided = false;
  const Rgba pixel = Renderer(scene).RenderPrimal(behind, Options(16)).pixels[0];
  EXPECT_EQ(pixel, Rgba(0, 0, 0, 1));
}

TEST(PathTracer, ZeroBouncesShowTheEnvironmentOnlyAndAHiddenOneStillLights) {
  Scene scene = tests::SceneOf(
      tests::Plate(1, 1, 0), LambertBsdf{}, {1, 1, 1}, {tests::ConstantEnvironment({2, 3, 4})});
  const Camera at_plate = tests::ProbeCamera({0, 0, 2}, {0, 0, 0});
  const Camera at_sky = tests::ProbeCamera({0, 0, 2}, {0, 0, 3});
  EXPECT_EQ(Renderer(scene).RenderPrimal(at_plate, Options(16, 0)).pixels[0], Rgba(0, 0, 0, 1));
  EXPECT_EQ(Renderer(scene).RenderPrimal(at_sky, Options(16, 0)).pixels[0], Rgba(2, 3, 4, 0));
  scene.environment_visible = false;
  EXPECT_EQ(Renderer(scene).RenderPrimal(at_sky, Options(16, 1)).pixels[0], Rgba(0, 0, 0, 0));
  EXPECT_TRUE(AgreesWithExact(Radiance(scene, at_plate, Options(256)), 2.0));
}

}  // namespace
}  // namespace pathfit::renderer::path_tracer_test
