#include "renderer/derivative/path_adjoint.h"

#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/probe.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer::path_adjoint_test {
namespace {

using tests::AgreesWithExact;
using tests::Channel;
constexpr double kPi = std::numbers::pi;
constexpr int kReplicates = 32;

RenderOptions Options(int spp, int max_bounces = 1) {
  RenderOptions options;
  options.spp = spp;
  options.max_bounces = max_bounces;
  options.terms.Set(DerivativeTerm::kPrimary, false);
  return options;
}

// C20: dR/dalpha of the white GGX reflector, by roughness (alpha = roughness^2).
TEST(PathAdjoint, GgxAlbedoByRoughness) {
  const double roughness = std::sqrt(0.3);
  const Scene scene = tests::SceneOf(tests::Plate(1, 1, 0),
                                     MetallicRoughnessBsdf{roughness, 1.0},
                                     {1, 1, 1},
                                     {tests::ConstantEnvironment({1, 1, 1})});
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kRoughness, 0);
  const auto estimate = [&](const Vec3& eye) {
    return Channel(tests::DerivativeReplicates(Renderer(scene),
                                               tests::ProbeCamera(eye, {0, 0, 0}),
                                               layout,
                                               {1.0},
                                               Options(8192),
                                               kReplicates),
                   1);
  };
  EXPECT_TRUE(AgreesWithExact(estimate({0, 0, 2}), -8.261023256234e-01 * 2.0 * roughness));
  EXPECT_TRUE(AgreesWithExact(estimate({0, 2, 2}), -8.300498981922e-01 * 2.0 * roughness));
}

// C21: E is linear in the map, so the derivative along texels k.w is (2 pi / 3) k.n.
TEST(PathAdjoint, IrradianceByEnvironmentTexels) {
  constexpr double kMapError =
      3e-4;  // bilinear texels of 1.4 degrees flatten the function a little
  const Vec3 k{0.3, -0.2, 0.5};
  const Scene scene = tests::SceneOf(
      tests::Plate(1, 1, 0), LambertBsdf{}, {1, 1, 1}, {tests::LinearEnvironment(1.0, k)});
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kEnvironmentTexels, 0);
  std::vector<double> direction;
  for (const Rgb& texel : std::get<EnvironmentEmitter>(scene.emitters[0].light).texels) {
    for (int c = 0; c < 3; ++c) direction.push_back(texel[c] - 1.0);
  }
  const auto d = tests::DerivativeReplicates(Renderer(scene),
                                             tests::ProbeCamera({0.5, 1, 2}, {0, 0, 0}),
                                             layout,
                                             direction,
                                             Options(1024),
                                             kReplicates);
  EXPECT_TRUE(AgreesWithExact(Channel(d, 2), 2.0 / 3.0 * k.z, 0.01, kMapError));
}

class CollocatedFlash : public ::testing::Test {
 protected:
  /// dL for a velocity field of the plane's vertices; the estimate has no noise.
  template <class Velocity>
  double Derivative(Velocity velocity) const {
    const tests::VertexMotion motion = tests::MoveMesh(scene_, velocity);
    return tests::DerivativeReplicates(
               Renderer(scene_), camera_, motion.layout, motion.direction, Options(1), 1)[0]
        .r;
  }
  const double r_ = 2.0;
  const double theta_ = 0.5;
  const Vec3 eye_{0, r_* std::sin(theta_), r_* std::cos(theta_)};
  const Vec3 away_ =
      -Normalized(eye_);  // from the eye through the point looked at, which is the origin
  const Scene scene_ =
      tests::SceneOf(tests::Plate(3, 3, 0),
                     LambertBsdf{},
                     {0.6, 0.6, 0.6},
                     {{"flash", LightFrame::kCamera, {}, PointEmitter{{0, 0, 0}, {3, 3, 3}}}});
  const Camera camera_ = tests::ProbeCamera(eye_, {0, 0, 0});
  Vec3 Away(const Vec3&) const { return away_; }
  /// Turning the plane so that the angle theta of the ray to its normal grows.
  static Vec3 Tilt(const Vec3& x) { return Cross(Vec3{1, 0, 0}, x); }
};

// C25, exact values to 1e-9.
TEST_F(CollocatedFlash, ByDistance) {
  EXPECT_NEAR(Derivative([&](const Vec3& x) { return Away(x); }), -1.257044424265e-01, 1e-9);
}
TEST_F(CollocatedFlash, ByTilt) { EXPECT_NEAR(Derivative(Tilt), -6.867264988202e-02, 1e-9); }
TEST_F(CollocatedFlash, ByHeightAboveThePlane) {
  // dh at a fixed point of the plane changes r by cos(theta) and theta by -sin(theta) / r.
  const auto rise = [&](const Vec3& x) {
    return Away(x) * std::cos(theta_) - Tilt(x) * (std::sin(theta_) / r_);
  };
  EXPECT_NEAR(Derivative(rise), -9.385431554711e-02, 1e-9);
}
TEST_F(CollocatedFlash, SlidingThePlaneInItselfChangesNothing) {
  EXPECT_NEAR(Derivative([](const Vec3&) { return Vec3{0.7, -0.4, 0.0}; }), 0.0, 1e-12);
}

// Everything scales about the pinhole, which is also the lamp: I(s) = I(1) / s^2 for any closed
// body, at any number of bounces. G, J and cosines of every segment must balance.
TEST(PathAdjoint, ScalingAClosedRoomAboutItsLamp) {
  Scene scene =
      tests::SceneOf(tests::Cube(),
                     LambertBsdf{},
                     {0.7, 0.5, 0.3},
                     {{"lamp", LightFrame::kWorld, {}, PointEmitter{{0, 0, 0}, {4, 4, 4}}}});
  const Camera camera = tests::CameraAt({0, 0, 0}, {0.3, 0.2, -1}, 3.0, 6, 6);
  for (const Bsdf& bsdf : {Bsdf{LambertBsdf{}}, Bsdf{MetallicRoughnessBsdf{0.6, 0.4}}}) {
    scene.materials[0].bsdf = bsdf;
    const tests::VertexMotion motion = tests::MoveMesh(scene, [](const Vec3& x) { return x; });
    for (const int bounces : {1, 2, 4}) {
      const Renderer renderer(scene);
      const double image =
          tests::EstimateMean(
              Channel(tests::PrimalReplicates(renderer, camera, Options(4096, bounces), 8), 0))
              .mean;
      const auto d = tests::DerivativeReplicates(
          renderer, camera, motion.layout, motion.direction, Options(64, bounces), kReplicates);
      EXPECT_TRUE(AgreesWithExact(Channel(d, 0), -2.0 * image)) << bounces << " bounces";
    }
  }
}

// dL_N / drho of the closed sphere with a lamp in its centre, L_N = c (rho + ... + rho^N).
TEST(PathAdjoint, AlbedoOfAClosedSphere) {
  constexpr double kMeshError = 3e-4;  // faces lie a little inside the sphere, unevenly
  const double rho = 0.7;
  const Scene scene =
      tests::SceneOf(MakeIcosphere(3, 1.0),
                     LambertBsdf{},
                     {rho, rho, rho},
                     {{"lamp", LightFrame::kWorld, {}, PointEmitter{{0, 0, 0}, {kPi, kPi, kPi}}}});
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kBaseColor, 0);
  const Camera camera = tests::CameraAt({0, 0, 0.2}, {0, 0, -1}, 2.0, 4, 4);
  const Renderer renderer(scene);
  const double c = tests::SumOfPixels(renderer.RenderPrimal(camera, Options(4096, 1))).r / rho;
  for (const int bounces : {1, 2, 3, 4}) {
    double exact = 0.0;
    for (int k = 1; k <= bounces; ++k) exact += c * k * std::pow(rho, k - 1);
    const auto d = tests::DerivativeReplicates(
        renderer, camera, layout, {1, 0, 0}, Options(512, bounces), kReplicates);
    EXPECT_TRUE(AgreesWithExact(Channel(d, 0), exact, 0.01, kMeshError)) << bounces;
    EXPECT_EQ(d[0].g, 0.0) << "red albedo does not act on green";
    EXPECT_EQ(d[0].a, 0.0);
  }
}

TEST(PathAdjoint, WhiteBalanceIsTheImageInOneChannel) {
  const Scene scene = tests::BallAndWall();
  const Renderer renderer(scene);
  Camera camera = scene.sensors[0];
  camera.gain = 1.7;
  camera.red = 1.2;
  camera.blue = 0.7;
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kWhiteBalance, 0);
  FilmSink red(layout, {1.2, 0.0}, camera.width, camera.height);
  FilmSink blue(layout, {0.0, 0.7}, camera.width, camera.height);
  const RenderOptions options = Options(8, 3);
  const Film film = renderer.RenderDerivative(camera, 0, options, layout, red);
  renderer.RenderDerivative(camera, 0, options, layout, blue);
  camera.red = camera.blue = 1.0;
  const Film plain = renderer.RenderPrimal(camera, options);
  double sum = 0.0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const renderer::Rgba& all = film.pixels[i];
    sum += all.r + all.b;
    EXPECT_NEAR(all.r, 1.2 * plain.pixels[i].r, 1e-12 * (1.0 + all.r));
    EXPECT_NEAR(all.b, 0.7 * plain.pixels[i].b, 1e-12 * (1.0 + all.b));
    EXPECT_NEAR(red.film().pixels[i].r, all.r, 1e-10 * (1.0 + all.r));
    EXPECT_NEAR(blue.film().pixels[i].b, all.b, 1e-10 * (1.0 + all.b));
    EXPECT_EQ(red.film().pixels[i].g + red.film().pixels[i].b, 0.0);
    EXPECT_EQ(blue.film().pixels[i].r + blue.film().pixels[i].g, 0.0);
  }
  EXPECT_GT(sum, 1.0);
}

TEST(PathAdjoint, EachChannelsDerivativesHaveItsGain) {
  // Of all terms, sample by sample; coverage has none.
  const Scene scene = tests::BallAndWall();
  const Renderer renderer(scene);
  Camera camera = scene.sensors[0];
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kObjectTranslation, 0);
  const RenderOptions options = Options(4, 2);
  const std::vector<double> along = {0.3, 0.2, -0.1};
  FilmSink plain(layout, along, camera.width, camera.height);
  renderer.RenderDerivative(camera, 0, options, layout, plain);
  camera.gain = 2.0;
  camera.red = 1.5;
  camera.blue = 0.5;
  FilmSink tinted(layout, along, camera.width, camera.height);
  renderer.RenderDerivative(camera, 0, options, layout, tinted);
  double sum = 0.0;
  for (std::size_t i = 0; i < plain.film().pixels.size(); ++i) {
    const renderer::Rgba& p = plain.film().pixels[i];
    const renderer::Rgba& t = tinted.film().pixels[i];
    sum += std::abs(p.g);
    EXPECT_NEAR(t.r, 3.0 * p.r, 1e-9 * (1.0 + std::abs(t.r)));
    EXPECT_NEAR(t.g, 2.0 * p.g, 1e-9 * (1.0 + std::abs(t.g)));
    EXPECT_NEAR(t.b, 1.0 * p.b, 1e-9 * (1.0 + std::abs(t.b)));
    EXPECT_NEAR(t.a, p.a, 1e-9 * (1.0 + std::abs(t.a)));
  }
  EXPECT_GT(sum, 0.1);
}

TEST(PathAdjoint, IntensityAndExposureAreTheImageItself) {
  const Scene scene = tests::BallAndWall();
  const Renderer renderer(scene);
  Camera camera = scene.sensors[0];
  camera.gain = 1.7;
  RenderOptions options = Options(8, 3);
  ParameterLayout layout(scene);
  for (int light = 0; light < 3; ++light) layout.Add(ParameterKind::kLightIntensity, light);
  layout.Add(ParameterKind::kExposure, 0);
  const std::vector<double> values = layout.Gather(scene);
  // The image is linear in all intensities together, and in the gain: without noise, sample by
  // sample.
  std::vector<double> along = values;
  along.back() = 0.0;
  std::vector<double> gain(values.size());
  gain.back() = 1.7;
  FilmSink lights(layout, along, camera.width, camera.height);
  FilmSink exposure(layout, gain, camera.width, camera.height);
  const Film film = renderer.RenderDerivative(camera, 0, options, layout, lights);
  renderer.RenderDerivative(camera, 0, options, layout, exposure);
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(lights.film().pixels[i][c], film.pixels[i][c], 1e-10 * (1.0 + film.pixels[i][c]));
      EXPECT_NEAR(
          exposure.film().pixels[i][c], film.pixels[i][c], 1e-10 * (1.0 + film.pixels[i][c]));
    }
    EXPECT_EQ(exposure.film().pixels[i].a, 0.0);
  }
}

}  // namespace
}  // namespace pathfit::renderer::path_adjoint_test
