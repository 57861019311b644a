// Scenes of the Mitsuba 3 test suite whose references lie in data/references/mitsuba: what they
// need is only Lambert, a constant sky and a point light. Spheres are analytic there and fine
// meshes here.
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "renderer/derivative/film_sink.h"
#include "renderer/io/exr_file.h"
#include "renderer/renderer.h"
#include "tests/support/test_scenes.h"

namespace pathfit {
namespace {

using renderer::Image;
using renderer::ParameterKind;
using renderer::Rgb;
using renderer::Scene;
using renderer::Vec3;

constexpr double kMaxRelativeError = 0.05;
constexpr double kMinCorrelation = 0.99;

Image Reference(const std::string& name) {
  return renderer::ReadExr(std::filesystem::path(PATHFIT_SOURCE_DIR) / "data/references/mitsuba" /
                           (name + ".exr"));
}

/// At distance 4 the 50 mm default lens of the reference shows one unit as 52.29764 pixels.
renderer::Camera ReferenceCamera() {
  return tests::CameraAt({0, 0, 4}, {0, 0, 0}, 4.0 * 52.29764, 128, 128);
}

renderer::Material OneSided(const std::string& name, double albedo) {
  return {name, renderer::LambertBsdf{}, Rgb::Constant(albedo), false, false};
}

/// A ball half sunk into the plane z = 0.
Scene BallInPlane(double plane_albedo, const renderer::Emitter& light) {
  Scene scene;
  scene.meshes = {{"plane", tests::Rectangle(), 0}, {"ball", renderer::MakeIcosphere(5, 0.25), 1}};
  scene.materials = {OneSided("plane", plane_albedo), OneSided("ball", 0.5)};
  scene.emitters = {light};
  return scene;
}

struct Agreement {
  double relative_error = 0.0;  ///< |ours - reference| / |reference|, L2 over pixels and channels
  double correlation = 0.0;
};
Agreement Compare(const renderer::Film& ours, const Image& reference) {
  EXPECT_EQ(ours.width, reference.width);
  EXPECT_EQ(ours.height, reference.height);
  EXPECT_EQ(reference.channels, 3);
  double n = 0.0, sum_a = 0.0, sum_b = 0.0, sum_aa = 0.0, sum_bb = 0.0, sum_ab = 0.0;
  for (std::size_t i = 0; i < ours.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const double a = ours.pixels[i][c];
      const double b = reference.data[3 * i + static_cast<std::size_t>(c)];
      n += 1.0;
      sum_a += a;
      sum_b += b;
      sum_aa += a * a;
      sum_bb += b * b;
      sum_ab += a * b;
    }
  }
  const double covariance = sum_ab - sum_a * sum_b / n;
  return {std::sqrt((sum_aa - 2.0 * sum_ab + sum_bb) / sum_bb),
          covariance / std::sqrt((sum_aa - sum_a * sum_a / n) * (sum_bb - sum_b * sum_b / n))};
}

void CheckScene(const std::string& name,
                const Scene& scene,
                ParameterKind kind,
                int object,
                const Rgb& direction_per_block) {
  renderer::ParameterLayout layout(scene);
  layout.Add(kind, object);
  std::vector<double> direction;
  for (std::int32_t i = 0; i < layout.NumBlocks(); ++i) {
    for (int c = 0; c < 3; ++c) direction.push_back(direction_per_block[c]);
  }
  const renderer::Camera camera = ReferenceCamera();
  renderer::RenderOptions options;
  options.spp = 128;
  options.sppe = 128.0;
  renderer::FilmSink sink(layout, direction, camera.width, camera.height);
  const renderer::Film primal =
      renderer::Renderer(scene).RenderDerivative(camera, -1, options, layout, sink);
  for (const auto& [what, agreement] :
       {std::pair{"primal", Compare(primal, Reference(name + "_primal"))},
        std::pair{"derivative", Compare(sink.film(), Reference(name + "_fwd"))}}) {
    std::printf("%-38s %-10s relative L2 %.4f correlation %.5f\n",
                name.c_str(),
                what,
                agreement.relative_error,
                agreement.correlation);
    EXPECT_LE(agreement.relative_error, kMaxRelativeError) << name << " " << what;
    EXPECT_GE(agreement.correlation, kMinCorrelation) << name << " " << what;
  }
}

TEST(MitsubaReference, DiffuseAlbedo) {
  CheckScene("diffuse_albedo",
             BallInPlane(0.5, tests::ConstantEnvironment({1, 1, 1})),
             ParameterKind::kBaseColor,
             0,
             {1, 1, 1});
}

TEST(MitsubaReference, PointLightIntensity) {
  const renderer::Emitter lamp{
      "lamp", renderer::LightFrame::kWorld, {}, renderer::PointEmitter{{1.25, 0, 1}, {5, 5, 5}}};
  CheckScene("point_light_intensity",
             BallInPlane(1.0, lamp),
             ParameterKind::kLightIntensity,
             0,
             {1, 1, 1});
}

TEST(MitsubaReference, ConstantEmitterRadiance) {
  // The reference holds 0.977576 where the background's derivative is exactly one: 2 % of the error
  // is its own.
  CheckScene("constant_emitter_radiance",
             BallInPlane(0.5, tests::ConstantEnvironment({1, 1, 1})),
             ParameterKind::kLightIntensity,
             0,
             {1, 1, 1});
}

TEST(MitsubaReference, TranslateDiffuseRectangle) {
  Scene scene;
  scene.meshes = {{"plane", tests::Rectangle(), 0}};
  scene.materials = {OneSided("plane", 0.5)};
  scene.emitters = {tests::ConstantEnvironment({1, 1, 1})};
  CheckScene(
      "translate_diffuse_rectangle_constant", scene, ParameterKind::kVertexPositions, 0, {1, 0, 0});
}

}  // namespace
}  // namespace pathfit
