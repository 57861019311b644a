#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "optim/diagnostics/gradient_check.h"
#include "renderer/core/error.h"
#include "renderer/geometry/mesh_primitives.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/optim/diagnostics/gradient_cases.h"
#include "tests/support/test_scenes.h"

namespace pathfit::optim::gradient_comparison_test {
namespace {

using renderer::Film;
using renderer::Rgba;

constexpr int kReplicates = 32;
constexpr int kSide = 16;

/// Truth 1 everywhere; the difference carries unit normal noise, both terms add up to 1 + bias
/// without noise.
GradientCheckResult Synthetic(double bias, double noise) {
  GradientCheckResult result;
  for (std::uint64_t r = 0; r < kReplicates; ++r) {
    Film interior(kSide, kSide);
    Film primary(kSide, kSide);
    Film difference(kSide, kSide);
    for (std::size_t i = 0; i < interior.pixels.size(); ++i) {
      renderer::CounterRng rng(r, renderer::RandomDomain{9}, 0, i, 0);
      for (int c = 0; c < 4; ++c) {
        const double u = 1.0 - rng.Next();
        const double normal =
            std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * rng.Next());
        interior.pixels[i][c] = 0.25 + bias;
        primary.pixels[i][c] = 0.75;
        difference.pixels[i][c] = 1.0 + noise * normal;
      }
    }
    result.terms[0].push_back(interior);
    result.terms[1].push_back(primary);
    result.difference.push_back(difference);
  }
  return result;
}

TEST(GradientComparison, PureNoiseHasUnitZ) {
  const GradientComparison c = Compare(Synthetic(0.0, 0.3), 1);
  EXPECT_EQ(c.count, kSide * kSide * 4);
  // Student's t of 31 degrees has variance 31 / 29; 1024 values scatter by 2 percent.
  EXPECT_NEAR(c.z_rms, std::sqrt(31.0 / 29.0), 0.1);
  EXPECT_LT(c.z_max, c.z_limit);
  EXPECT_NEAR(c.signal_to_noise, std::sqrt(32.0) / 0.3, 1.0);
}

TEST(GradientComparison, FindsAMissingOrFlippedTerm) {
  const GradientCheckResult result = Synthetic(0.0, 0.3);
  for (const Term term : {Term::kInterior, Term::kPrimary}) {
    for (const double scale : {0.0, -1.0}) {
      const GradientCheckResult mutant = tests::Mutant(result, term, scale);
      EXPECT_GT(Compare(mutant, 1).z_rms, 3.0);
      EXPECT_GT(Compare(mutant, 0).z_max, Compare(mutant, 0).z_limit);
    }
  }
}

TEST(GradientComparison, LargerTilesFindSmallerBiases) {
  const GradientCheckResult result = Synthetic(0.02, 0.3);
  EXPECT_LT(Compare(result, 1).z_rms, 1.3);
  EXPECT_GT(Compare(result, 0).z_rms, 5.0)
      << "0.02 of 1 under an error bar of 0.3 / sqrt(32 * 256)";
  EXPECT_EQ(Compare(result, 0).count, 4);
}

TEST(GradientComparison, EqualConstantsPassAndUnequalConstantsFail) {
  const GradientComparison equal = Compare(Synthetic(0.0, 0.0), 4);
  EXPECT_EQ(equal.z_max, 0.0);
  EXPECT_EQ(equal.count, 64);
  EXPECT_GT(Compare(Synthetic(0.01, 0.0), 4).z_max, 1e3);
}

TEST(GradientComparison, ZeroAgainstZeroCarriesNoInformation) {
  GradientCheckResult result = Synthetic(0.0, 0.0);
  for (auto* films : {&result.terms[0], &result.terms[1], &result.difference}) {
    for (Film& film : *films) film = Film(kSide, kSide);
  }
  EXPECT_EQ(Compare(result, 4).count, 0);
}

/// Four values share the two-sided tail of 4 sigma, 6.334e-5: the upper 7.918e-06 quantile of
/// Student's t with 31 degrees of freedom is 5.106.
TEST(GradientComparison, LimitIsTheStudentQuantileOverAllTiles) {
  EXPECT_NEAR(Compare(Synthetic(0.0, 0.3), 0).z_limit, 5.106, 0.01);
  EXPECT_GT(Compare(Synthetic(0.0, 0.3), 0, 5.0).z_limit, 6.0) << "rarer alarms, wider limit";
}

// A small step gives few samples another lobe, each of much weight: tiles without any have a tiny
// spread and a shifted mean.
TEST(CheckGradient, SamplesThatChangeTheirLobeAreInTheErrorBars) {
  renderer::Scene scene;
  scene.materials = {{"paint", renderer::MetallicRoughnessBsdf{0.35, 0.3, 0.7}, {0.7, 0.3, 0.2}}};
  scene.meshes = {{"ball", renderer::MakeIcosphere(3, 0.5), 0, {}}};
  scene.emitters = {{"sky", renderer::LightFrame::kWorld, {}, renderer::EnvironmentEmitter{}}};
  scene.sensors = {tests::CameraAt({0, 0, 2}, {0, 0, 0}, 40.0, 16, 16)};
  renderer::ParameterLayout layout(scene);
  layout.Add(renderer::ParameterKind::kSpecular, 0);
  GradientCheckOptions options;
  options.render.spp = 64;
  options.difference_spp = 128;
  options.step = 1e-4;
  const renderer::Camera& camera = scene.sensors[0];
  const auto result = CheckGradient(scene, camera, -1, layout, {1.0}, options);
  const GradientComparison comparison = Compare(result, 4);
  EXPECT_LT(comparison.z_max, comparison.z_limit);
  GradientCheckResult unaware = result;
  unaware.changes_lobes = false;
  EXPECT_GT(Compare(unaware, 4).z_max, comparison.z_limit) << "what this is about";
}

// Directional light on a plane has no noise: a difference is then told from the derivative by its
// own error, a sixth of the step's square here.
TEST(CheckGradient, TheStepsOwnErrorIsInTheErrorBarsAndAWrongDerivativeIsFoundAllTheSame) {
  renderer::Scene scene;
  scene.materials = {{"paint", renderer::LambertBsdf{}, {0.7, 0.3, 0.2}}};
  scene.meshes = {{"floor", renderer::MakeRectangle(), 0, {}}};
  scene.emitters = {{"sun",
                     renderer::LightFrame::kWorld,
                     {},
                     renderer::DirectionalEmitter{{0.6, 0.0, -0.8}, {1.0, 1.0, 1.0}}}};
  scene.sensors = {tests::CameraAt({0, 0, 1}, {0, 0, 0}, 40.0, 16, 16)};
  renderer::ParameterLayout layout(scene);
  layout.Add(renderer::ParameterKind::kLightRotation, 0);
  GradientCheckOptions options;
  options.render.spp = 4;
  options.difference_spp = 4;
  options.replicates = 8;
  options.step = 0.01;
  const std::vector<double> about_y = {0.0, 1.0, 0.0};
  const renderer::Camera& camera = scene.sensors[0];
  GradientCheckResult result = CheckGradient(scene, camera, -1, layout, about_y, options);
  EXPECT_GT(Compare(result, 4).z_max, 100.0 * Compare(result, 4).z_limit) << "what this is about";
  AddHalvedDifference(scene, camera, -1, layout, about_y, options, result);
  for (const int tile : {4, 0}) {
    const GradientComparison right = Compare(result, tile);
    EXPECT_NEAR(right.z_max, 1.0, 0.01);
    EXPECT_NEAR(right.truncation, options.step * options.step / 6.0, 1e-7);
    const GradientComparison wrong = Compare(tests::Mutant(result, Term::kInterior, 1.001), tile);
    EXPECT_GT(wrong.z_max, wrong.z_limit);
  }
}

TEST(GradientComparison, ADifferenceThatIsAnotherByChanceHasNoTruncation) {
  GradientCheckResult result = Synthetic(0.0, 0.3);
  const GradientComparison before = Compare(result, 4);
  const GradientCheckResult other = Synthetic(0.0, 0.3);
  result.halved = {
      other.difference[4], other.difference[5], other.difference[6], other.difference[7]};
  const GradientComparison c = Compare(result, 4);
  EXPECT_NEAR(c.z_rms, before.z_rms, 0.02 * before.z_rms);
  EXPECT_LT(c.truncation, 0.02);
  for (Film& film : result.halved) {
    for (Rgba& p : film.pixels) p *= 0.25;
  }
  EXPECT_NEAR(Compare(result, 4).truncation, 1.0, 0.1);
  EXPECT_NEAR(Compare(result, 4).signal_to_noise, 1.0, 0.1);
}

TEST(CheckGradient, RefusesAStepOutOfTheValidScenes) {
  renderer::Scene scene = tests::BallAndWall();
  renderer::ParameterLayout layout(scene);
  layout.Add(renderer::ParameterKind::kMetallic, 1);
  GradientCheckOptions options;
  options.replicates = 2;
  options.step = 0.5;  // 0.6 + 0.5 is no metallic value
  EXPECT_THROW(CheckGradient(scene, scene.sensors[0], -1, layout, {1.0}, options),
               renderer::SceneError);
}

TEST(MeanFilm, IsTheMean) {
  Film a(1, 1);
  Film b(1, 1);
  a.pixels[0] = {1, 2, 3, 4};
  b.pixels[0] = {3, 2, 1, 0};
  EXPECT_EQ(MeanFilm({a, b}).pixels[0], Rgba(2, 2, 2, 2));
}

}  // namespace
}  // namespace pathfit::optim::gradient_comparison_test
