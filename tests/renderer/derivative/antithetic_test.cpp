#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/probe.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer::antithetic_test {
namespace {

/// A rough metal plate under a smooth sky; it turns.
Scene GlossyPlate(double roughness) {
  Scene scene = tests::SceneOf(tests::Plate(1.0, 1.0, 0.0),
                               RoughConductorBsdf{roughness, {0.2, 0.9, 1.1}, {3.9, 2.4, 2.1}},
                               {1.0, 1.0, 1.0},
                               {tests::GradientEnvironment(16, 8)});
  scene.sensors = {tests::CameraAt({0.3, 0.2, 3.0}, {0, 0, 0}, 30.0, 8, 8)};
  return scene;
}

struct Moments {
  double mean = 0.0, variance = 0.0;
};

/// Derivative of the image's sum by turning the plate, interior only.
Moments Turning(const Scene& scene, bool antithetic, int count) {
  const Renderer renderer(scene);
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kObjectRotation, 0);
  RenderOptions options;
  options.terms = {DerivativeTerm::kInterior};
  options.spp = 16;
  options.antithetic = antithetic;
  std::vector<double> sums;
  for (int i = 0; i < count; ++i) {
    options.seed = static_cast<std::uint64_t>(i) + (antithetic ? 1000 : 0);
    FilmSink sink(layout, {0.3, 1.0, 0.0}, 8, 8);
    renderer.RenderDerivative(scene.sensors[0], 0, options, layout, sink);
    sums.push_back(tests::SumOfPixels(sink.film()).g);
  }
  Moments m;
  for (const double s : sums) m.mean += s / count;
  for (const double s : sums) m.variance += (s - m.mean) * (s - m.mean) / (count - 1);
  return m;
}

TEST(Antithetic, SameMeanAndFarLessNoiseForGlossyReflections) {
  constexpr int kCount = 64;
  for (const auto& [roughness, least_ratio] : {std::pair{0.25, 6.0}, {0.4, 2.0}}) {
    const Scene scene = GlossyPlate(roughness);
    const Moments plain = Turning(scene, false, kCount);
    const Moments pairs = Turning(scene, true, kCount);
    const double z =
        (plain.mean - pairs.mean) / std::sqrt((plain.variance + pairs.variance) / kCount);
    EXPECT_LT(std::abs(z), 4.0) << plain.mean << " against " << pairs.mean;
    std::printf("roughness %.2f: %.5g +- %.2g, pairs %.5g +- %.2g, variance ratio %.1f\n",
                roughness,
                plain.mean,
                std::sqrt(plain.variance / kCount),
                pairs.mean,
                std::sqrt(pairs.variance / kCount),
                plain.variance / pairs.variance);
    EXPECT_GT(plain.variance, least_ratio * pairs.variance) << roughness;
  }
}

/// Two rough metal plates that reflect each other: only one vertex of a path may be mirrored.
TEST(Antithetic, SameMeanOverTwoGlossyReflections) {
  Scene scene = GlossyPlate(0.8);
  Mesh wall = tests::Plate(1.0, 1.0, 0.0);
  ApplyTransform({RotationAboutAxis({0, 1, 0}, 2.0), {-0.7, 0.0, 0.7}}, wall);
  scene.meshes.push_back({"wall", wall, 0, {}});
  scene.sensors = {tests::CameraAt({2.0, 0.4, 0.8}, {-0.3, 0, 0.1}, 30.0, 8, 8)};
  const Renderer renderer(scene);
  RenderOptions options;
  options.spp = 1024;
  options.max_bounces = 3;
  std::array<tests::MeanAndError, 2> means;
  for (const bool antithetic : {false, true}) {
    options.antithetic = antithetic;
    options.view = antithetic ? 1 : 0;
    means[antithetic ? 1 : 0] = tests::EstimateMean(
        tests::Channel(tests::PrimalReplicates(renderer, scene.sensors[0], options, 48), 1));
  }
  const double error = std::hypot(means[0].error, means[1].error);
  EXPECT_NEAR(means[0].mean, means[1].mean, 4.0 * error);
  EXPECT_LT(error, 1e-3 * means[0].mean);
}

TEST(Antithetic, SamplesAreWholePairs) {
  const Scene scene = GlossyPlate(0.5);
  const Renderer renderer(scene);
  RenderOptions options;
  options.antithetic = true;
  options.spp = 3;
  const Film odd = renderer.RenderPrimal(scene.sensors[0], options);
  options.spp = 4;
  EXPECT_EQ(odd.pixels, renderer.RenderPrimal(scene.sensors[0], options).pixels);
}

TEST(Antithetic, TheImageOfADerivativeIsThePrimalImage) {
  const Scene scene = GlossyPlate(0.3);
  const Renderer renderer(scene);
  ParameterLayout layout(scene);
  layout.Add(ParameterKind::kObjectRotation, 0);
  RenderOptions options;
  options.antithetic = true;
  FilmSink sink(layout, {1.0, 0.0, 0.0}, 8, 8);
  const Film a = renderer.RenderPrimal(scene.sensors[0], options);
  const Film b = renderer.RenderDerivative(scene.sensors[0], 0, options, layout, sink);
  EXPECT_EQ(a.pixels, b.pixels);
}

}  // namespace
}  // namespace pathfit::renderer::antithetic_test
