#include <gtest/gtest.h>

#include "renderer/sampler/path_sampler.h"
#include "tests/support/statistics.h"

namespace pathfit::renderer::lattice_sampler_test {
namespace {

constexpr int kAll = LatticeSampler::kDimensions + 2;
constexpr int kSuite = 2 * kAll + LatticeSampler::kDimensions - 1;

/// A sampler together with its pixel's lattice.
class OwningSampler {
 public:
  OwningSampler(std::uint64_t seed, std::uint64_t pixel, std::uint64_t sample)
      : shift_(CounterRng(seed, RandomDomain{1}, 0, pixel, 0)),
        sampler_(shift_, CounterRng(seed, RandomDomain{2}, 0, pixel, sample), sample) {}
  OwningSampler(const OwningSampler&) = delete;
  OwningSampler& operator=(const OwningSampler&) = delete;
  double Next() { return sampler_.Next(); }

 private:
  LatticeSampler::Shift shift_;
  LatticeSampler sampler_;
};

TEST(LatticeSampler, EveryDimensionIsUniformOverPixels) {
  constexpr std::uint64_t kPixels = 50000;
  for (const std::uint64_t sample : {0U, 13U}) {
    std::vector<std::vector<double>> counts(kAll, std::vector<double>(50));
    for (std::uint64_t pixel = 0; pixel < kPixels; ++pixel) {
      OwningSampler sampler(5, pixel, sample);
      for (auto& c : counts) {
        const double u = sampler.Next();
        ASSERT_GE(u, 0.0);
        ASSERT_LT(u, 1.0);
        c[static_cast<std::size_t>(u * 50.0)] += 1.0;
      }
    }
    for (const auto& c : counts) {
      EXPECT_TRUE(tests::ChiSquareAccepts(c, std::vector<double>(50, kPixels / 50.0), kSuite));
    }
  }
}

TEST(LatticeSampler, ShiftsOfTwoDimensionsAreIndependent) {
  constexpr std::uint64_t kPixels = 60000;
  std::vector<std::vector<double>> counts(LatticeSampler::kDimensions - 1,
                                          std::vector<double>(100));
  for (std::uint64_t pixel = 0; pixel < kPixels; ++pixel) {
    OwningSampler sampler(6, pixel, 3);
    double previous = sampler.Next();
    for (auto& c : counts) {
      const double u = sampler.Next();
      c[static_cast<std::size_t>(previous * 10.0) * 10 + static_cast<std::size_t>(u * 10.0)] += 1.0;
      previous = u;
    }
  }
  for (const auto& c : counts) {
    EXPECT_TRUE(tests::ChiSquareAccepts(c, std::vector<double>(100, kPixels / 100.0), kSuite));
  }
}

/// The reason for the lattice: the samples of one pixel leave no large gap in any dimension.
TEST(LatticeSampler, SamplesOfOnePixelSpreadEvenly) {
  constexpr int kSamples = 64;
  for (std::uint64_t pixel = 0; pixel < 50; ++pixel) {
    std::vector<std::vector<double>> values(LatticeSampler::kDimensions);
    for (int s = 0; s < kSamples; ++s) {
      OwningSampler sampler(8, pixel, static_cast<std::uint64_t>(s));
      for (auto& v : values) v.push_back(sampler.Next());
    }
    for (auto& v : values) {
      std::sort(v.begin(), v.end());
      double gap = v.front() + 1.0 - v.back();
      for (std::size_t i = 1; i < v.size(); ++i) gap = std::max(gap, v[i] - v[i - 1]);
      EXPECT_LT(gap, 6.0 / kSamples)
          << "independent numbers leave about ln(64) = 4.2 / 64, often twice that";
    }
  }
}

TEST(LatticeSampler, LaterDimensionsDifferFromSampleToSample) {
  OwningSampler a(1, 2, 0);
  OwningSampler b(1, 2, 1);
  for (int i = 0; i < LatticeSampler::kDimensions; ++i) {
    a.Next();
    b.Next();
  }
  EXPECT_NE(a.Next(), b.Next());
}

}  // namespace
}  // namespace pathfit::renderer::lattice_sampler_test
