#include "renderer/math/warp.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "renderer/sampler/counter_rng.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer::warp_test {
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

TEST(Warp, AnglesAsSharesOfATurn) {
  CounterRng rng(6);
  for (int i = 0; i < 20000; ++i) {
    // Axes and diagonals, and lengths of all orders, too.
    const double length = std::pow(10.0, 40.0 * rng.Next() - 20.0);
    const double angle = i < 16 ? i / 16.0 : rng.Next();
    const auto [sine, cosine] = SineCosineOfTurn(angle);
    const double x = length * cosine;
    const double y = i % 3 == 0 ? length * sine * 1e-9 : length * sine;
    const long double exact = std::atan2(static_cast<long double>(y), static_cast<long double>(x)) /
                              (2.0L * std::numbers::pi_v<long double>);
    ASSERT_NEAR(TurnOf(y, x), static_cast<double>(exact < 0.0L ? exact + 1.0L : exact), 2.5e-16);
    const double polar = 2.0 * rng.Next() - 1.0;
    ASSERT_NEAR(PolarShare(polar),
                static_cast<double>(std::acos(static_cast<long double>(polar)) /
                                    std::numbers::pi_v<long double>),
                3e-16);
  }
  EXPECT_EQ(TurnOf(0.0, 0.0), 0.0);
  EXPECT_EQ(TurnOf(0.0, 1.0), 0.0);
  EXPECT_EQ(TurnOf(1.0, 0.0), 0.25);
  EXPECT_EQ(TurnOf(0.0, -1.0), 0.5);
  EXPECT_EQ(TurnOf(-1.0, 0.0), 0.75);
  EXPECT_EQ(PolarShare(1.0), 0.0);
  EXPECT_EQ(PolarShare(-1.0), 1.0);
}

}  // namespace
}  // namespace pathfit::renderer::warp_test
