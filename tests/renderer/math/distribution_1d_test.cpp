#include "renderer/math/distribution_1d.h"

#include <cmath>

#include <gtest/gtest.h>

#include "renderer/sampler/counter_rng.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer::distribution_1d_test {
namespace {

TEST(Distribution1D, DrawsWithItsProbabilities) {
  const std::vector<double> weights = {
      0.5, 0.0, 3.0, 1.0, 0.25, 2.0, 0.125, 1.0, 4.0, 0.5, 0.7, 0.3};
  const Distribution1D distribution(weights);
  constexpr int kDraws = 200000;
  std::vector<double> observed(weights.size());
  std::vector<double> expected;
  double sum = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double p = distribution.Probability(static_cast<int>(i));
    expected.push_back(kDraws * p);
    sum += p;
  }
  EXPECT_NEAR(sum, 1.0, 1e-15);
  std::vector<double> remainders(20);
  CounterRng rng(2);
  for (int i = 0; i < kDraws; ++i) {
    double remainder = -1.0;
    const int index = distribution.Sample(rng.Next(), remainder);
    ASSERT_GE(remainder, 0.0);
    ASSERT_LT(remainder, 1.0);
    observed[static_cast<std::size_t>(index)] += 1.0;
    remainders[static_cast<std::size_t>(remainder * 20.0)] += 1.0;
  }
  EXPECT_EQ(observed[1], 0.0) << "a weight of zero is never drawn";
  EXPECT_TRUE(tests::ChiSquareAccepts(observed, expected, 2));
  EXPECT_TRUE(tests::ChiSquareAccepts(remainders, std::vector<double>(20, kDraws / 20.0), 2));
}

TEST(Distribution1D, StaysInRangeAtBothEndsOfTheUnitInterval) {
  const Distribution1D distribution({0.0, 1.0, 2.0, 0.0});
  double remainder = 0.0;
  EXPECT_EQ(distribution.Sample(0.0, remainder), 1);
  EXPECT_EQ(distribution.Sample(std::nextafter(1.0, 0.0), remainder), 2);
}

TEST(Distribution1D, IsEmptyWithoutWeight) {
  EXPECT_TRUE(Distribution1D().Empty());
  EXPECT_TRUE(Distribution1D({0.0, 0.0}).Empty());
  EXPECT_FALSE(Distribution1D({0.0, 0.1}).Empty());
  EXPECT_EQ(Distribution1D({1.0, 2.0}).Total(), 3.0);
}

/// Buckets only shorten the search: the index is that of the definition, whatever the weights.
TEST(Distribution1D, FindsTheIndexOfTheDefinition) {
  CounterRng rng(9);
  for (const double spread : {0.0, 1.0, 40.0, 600.0}) {
    std::vector<double> weights(200);
    std::vector<double> sums = {0.0};
    for (double& w : weights) {
      w = rng.Next() < 0.2 ? 0.0 : std::exp(spread * (rng.Next() - 0.5));
      sums.push_back(sums.back() + w);
    }
    const Distribution1D distribution(weights);
    for (int i = 0; i < 20000; ++i) {
      const int first = static_cast<int>(rng.Next() * 100.0);
      const int end = first + 1 + static_cast<int>(rng.Next() * 100.0);
      const double u = i % 7 == 0 ? 0.0 : rng.Next();
      const double low = sums[static_cast<std::size_t>(first)];
      const double target = low + u * (sums[static_cast<std::size_t>(end)] - low);
      int expected = first;
      for (int k = first + 1; k < end; ++k) {
        expected = sums[static_cast<std::size_t>(k)] <= target ? k : expected;
      }
      double remainder = 0.0;
      ASSERT_EQ(distribution.SampleWithin(first, end, u, remainder), expected) << spread;
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer::distribution_1d_test
