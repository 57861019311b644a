#include "renderer/sampler/counter_rng.h"

#include <cmath>
#include <functional>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/statistics.h"

namespace pathfit::renderer::counter_rng_test {
namespace {

constexpr int kDraws = 200000;
constexpr int kSuite = 12;  // chi-square tests of this file

/// Uniformity of single numbers and of pairs (first, second) drawn by `draw(i)`.
void CheckUniform(const std::function<std::pair<double, double>(std::uint64_t)>& draw) {
  std::vector<double> single(64);
  std::vector<double> pairs(256);
  for (std::uint64_t i = 0; i < kDraws; ++i) {
    const auto [a, b] = draw(i);
    ASSERT_GE(a, 0.0);
    ASSERT_LT(a, 1.0);
    single[static_cast<std::size_t>(a * 64.0)] += 1.0;
    pairs[static_cast<std::size_t>(a * 16.0) * 16 + static_cast<std::size_t>(b * 16.0)] += 1.0;
  }
  EXPECT_TRUE(tests::ChiSquareAccepts(single, std::vector<double>(64, kDraws / 64.0), kSuite));
  EXPECT_TRUE(tests::ChiSquareAccepts(pairs, std::vector<double>(256, kDraws / 256.0), kSuite));
}

TEST(CounterRng, IsUniformAlongOneStream) {
  CounterRng rng(7);
  CheckUniform([&](std::uint64_t) {
    const double a = rng.Next();
    return std::pair{a, rng.Next()};
  });
}

/// Every part of the key: first numbers of neighbouring streams are uniform and independent of each
/// other.
TEST(CounterRng, NeighbouringStreamsAreUniformAndIndependent) {
  const auto first = [](const std::array<std::uint64_t, 5>& key) {
    return CounterRng(key[0], RandomDomain{key[1]}, key[2], key[3], key[4]).Next();
  };
  CheckUniform([&](std::uint64_t i) {
    return std::pair{first({i, 1, 2, 3, 4}), first({i + 1, 1, 2, 3, 4})};
  });
  CheckUniform([&](std::uint64_t i) {
    return std::pair{first({9, 1, i, 3, 4}), first({9, 1, i + 1, 3, 4})};
  });
  CheckUniform([&](std::uint64_t i) {
    return std::pair{first({9, 1, 2, i, 4}), first({9, 1, 2, i + 1, 4})};
  });
  CheckUniform([&](std::uint64_t i) {
    return std::pair{first({9, 1, 2, 3, i}), first({9, 1, 2, 3, i + 1})};
  });
  CheckUniform([&](std::uint64_t i) {
    return std::pair{first({9, 1, 2, i, 0}), first({9, 2, 2, i, 0})};
  });
}

TEST(CounterRng, SameKeySameNumbersOtherKeyOtherNumbers) {
  CounterRng a(1, RandomDomain{2}, 3, 4, 5);
  CounterRng b(1, RandomDomain{2}, 3, 4, 5);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(a.Next(), b.Next());
  std::set<double> firsts;
  for (std::uint64_t element = 0; element < 200; ++element) {
    for (std::uint64_t sample = 0; sample < 200; ++sample) {
      firsts.insert(CounterRng(1, RandomDomain{2}, 3, element, sample).Next());
    }
  }
  EXPECT_EQ(firsts.size(), 40000U) << "no two (element, sample) share a stream";
}

}  // namespace
}  // namespace pathfit::renderer::counter_rng_test
