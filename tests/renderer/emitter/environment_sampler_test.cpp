#include "renderer/emitter/environment_sampler.h"

#include <numbers>

#include <gtest/gtest.h>

#include "renderer/sampler/counter_rng.h"
#include "tests/support/statistics.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer::environment_sampler_test {
namespace {

constexpr int kRows = 12;     // in v
constexpr int kColumns = 20;  // in u
constexpr int kFine = 40;
constexpr int kDraws = 200000;
constexpr int kSuite = 5;
const Vec3 kNormal = Normalized(Vec3{0.2, 0.9, -0.4});

/// A dark map with one bright texel and a black half: the hard case for importance sampling.
EnvironmentEmitter Spot() {
  EnvironmentEmitter environment;
  environment.width = 16;
  environment.height = 8;
  environment.texels.assign(128, {0, 0, 0});
  for (std::size_t i = 0; i < 64; ++i) environment.texels[i] = {0.1, 0.1, 0.1};
  environment.texels[3 * 16 + 5] = {200, 180, 150};
  return environment;
}

void CheckSampler(const EnvironmentEmitter& environment) {
  const EnvironmentSampler sampler(environment);
  std::vector<double> observed(kRows * kColumns);
  std::vector<double> expected(kRows * kColumns);
  CounterRng rng(21);
  const auto cell = [](const Vec2& uv) {
    const int row = std::min(kRows - 1, static_cast<int>(uv.y * kRows));
    return static_cast<std::size_t>(row * kColumns +
                                    std::min(kColumns - 1, static_cast<int>(uv.x * kColumns)));
  };
  for (int i = 0; i < kDraws; ++i) {
    const double u0 = rng.Next();
    const DirectionSample sample = sampler.Sample(kNormal, u0, rng.Next());
    ASSERT_NEAR(Norm(sample.direction), 1.0, 1e-12);
    ASSERT_GT(sample.pdf, 0.0);
    observed[cell(EnvironmentUv(sample.direction))] += 1.0;
  }
  // Midpoint rule on a grid that divides both the map's texels and the cells.
  double integral = 0.0;
  const int rows = kRows * kFine;
  const int columns = kColumns * kFine;
  for (int y = 0; y < rows; ++y) {
    const double solid_angle =
        2.0 * std::numbers::pi / columns *
        (std::cos(std::numbers::pi * y / rows) - std::cos(std::numbers::pi * (y + 1) / rows));
    for (int x = 0; x < columns; ++x) {
      const Vec2 uv{(x + 0.5) / columns, (y + 0.5) / rows};
      const bool above = Dot(kNormal, EnvironmentDirection(uv)) > 0.0;
      const double p = sampler.Pdf(uv, above) * solid_angle;
      expected[cell(uv)] += kDraws * p;
      integral += p;
    }
  }
  EXPECT_NEAR(integral, 1.0, 2e-3) << "density integrates to one (error of the midpoint rule)";
  EXPECT_TRUE(tests::ChiSquareAccepts(observed, expected, kSuite));
}

TEST(EnvironmentSampler, SmoothMapFollowsItsPdf) {
  CheckSampler(std::get<EnvironmentEmitter>(tests::GradientEnvironment(16, 8).light));
}
TEST(EnvironmentSampler, SpotMapFollowsItsPdf) { CheckSampler(Spot()); }
TEST(EnvironmentSampler, ColumnAndRowMapsFollowTheirPdf) {
  CheckSampler(std::get<EnvironmentEmitter>(tests::GradientEnvironment(1, 6).light));
  CheckSampler(std::get<EnvironmentEmitter>(tests::GradientEnvironment(10, 1).light));
}
TEST(EnvironmentSampler, ConstantMapIsSampledOverTheReceiversHemisphere) {
  CheckSampler(std::get<EnvironmentEmitter>(tests::ConstantEnvironment({2, 2, 2}).light));
}

TEST(EnvironmentSampler, SamplesCarryThePdfOfTheirDirection) {
  const EnvironmentSampler sampler(Spot());
  CounterRng rng(22);
  int equal = 0;
  constexpr int kCount = 10000;
  for (int i = 0; i < kCount; ++i) {
    const double u0 = rng.Next();
    const DirectionSample sample = sampler.Sample(kNormal, u0, rng.Next());
    EXPECT_NEAR(sample.uv.x, EnvironmentUv(sample.direction).x, 1e-9);
    EXPECT_NEAR(sample.uv.y, EnvironmentUv(sample.direction).y, 1e-9);
    equal += sample.pdf == sampler.Pdf(EnvironmentUv(sample.direction), true) ? 1 : 0;
  }
  EXPECT_GE(equal, kCount - 2)
      << "rounding may move a sample on a border between texels to its neighbour";
}

TEST(EnvironmentSampler, BlackMapsAndBlackTexelsKeepAPositivePdf) {
  EnvironmentEmitter black = Spot();
  black.texels.assign(128, {0, 0, 0});
  EXPECT_NEAR(EnvironmentSampler(black).Pdf({0.3, 0.1}, true), 0.25 * std::numbers::inv_pi, 1e-12);
  EXPECT_GT(EnvironmentSampler(Spot()).Pdf({0.6, 0.9}, true), 0.0);
}

}  // namespace
}  // namespace pathfit::renderer::environment_sampler_test
