#include "renderer/math/warp.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "renderer/sampler/counter_rng.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer {
namespace {

constexpr int kRows = 8;
constexpr int kColumns = 12;
constexpr int kDraws = 100000;

/// Cells are equal in cos(theta) and phi, so that both expectations are elementary.
template <class Sample, class CellProbability>
void CheckAgainstCells(Sample sample, CellProbability probability_of_row) {
  std::vector<double> observed(kRows * kColumns);
  std::vector<double> expected(kRows * kColumns);
  CounterRng rng(3);
  for (int i = 0; i < kDraws; ++i) {
    const double u0 = rng.Next();
    const Vec3 d = sample(u0, rng.Next());
    ASSERT_NEAR(Norm(d), 1.0, 1e-12);
    const double phi = std::atan2(d.y, d.x) + std::numbers::pi;
    const int row = std::min(kRows - 1, static_cast<int>(d.z * kRows));
    const int column =
        std::min(kColumns - 1, static_cast<int>(phi * 0.5 * std::numbers::inv_pi * kColumns));
    observed[static_cast<std::size_t>(row * kColumns + column)] += 1.0;
  }
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      expected[static_cast<std::size_t>(row * kColumns + column)] =
          kDraws * probability_of_row(row) / kColumns;
    }
  }
  EXPECT_TRUE(tests::ChiSquareAccepts(observed, expected, 2));
}

TEST(Warp, CosineHemisphereFollowsItsDensity) {
  CheckAgainstCells(SampleCosineHemisphere, [](int row) {
    const double low = static_cast<double>(row) / kRows;
    const double high = static_cast<double>(row + 1) / kRows;
    return high * high - low * low;  // integral of 2 cos over the row
  });
  EXPECT_DOUBLE_EQ(CosineHemispherePdf(0.5), 0.5 / std::numbers::pi);
  EXPECT_EQ(CosineHemispherePdf(-0.1), 0.0);
}

TEST(Warp, UniformHemisphereFollowsItsDensity) {
  CheckAgainstCells(SampleUniformHemisphere, [](int) { return 1.0 / kRows; });
  EXPECT_DOUBLE_EQ(UniformHemispherePdf() * 2.0 * std::numbers::pi, 1.0);
}

TEST(Warp, SineAndCosineOfATurn) {
  CounterRng rng(5);
  for (int i = 0; i < 20000; ++i) {
    // Eighths, where the quarter that is taken off changes, and their neighbours, too.
    const double eighth = 0.125 * (i % 9);
    const double u = i < 9 ? eighth : i < 18 ? std::nextafter(eighth, 0.5) : rng.Next();
    const auto [sine, cosine] = SineCosineOfTurn(u);
    const long double angle = 2.0L * std::numbers::pi_v<long double> * u;
    ASSERT_NEAR(sine, static_cast<double>(std::sin(angle)), 2.5e-16) << u;
    ASSERT_NEAR(cosine, static_cast<double>(std::cos(angle)), 2.5e-16) << u;
  }
}

}  // namespace
}  // namespace pathfit::renderer
