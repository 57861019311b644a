#include "renderer/sensor/pixel_filter.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/finite_difference.h"

namespace pathfit::renderer::pixel_filter_test {
namespace {

using Shape = PixelFilter::Shape;

std::vector<PixelFilter> AllFilters() {
  return {{Shape::kBox, 0.5, 0.0},
          {Shape::kBox, 1.7, 0.0},
          {Shape::kTent, 1.0, 0.0},
          {Shape::kTent, 0.4, 0.0},
          {Shape::kGaussian, 2.0, 0.5},
          {Shape::kGaussian, 1.5, 0.8},
          {Shape::kGaussian, 8.0, 1.0},
          {Shape::kGaussian, 0.5, 20.0},
          {Shape::kGaussian, 8.0, 1e-3},
          {Shape::kGaussian, 1.0, 1e3}};
}

/// Integral from `low` to `high` by Gauss' rule of five points on cells; exact to rounding for
/// these smooth pieces.
double Integral(const PixelFilter& filter, double low, double high) {
  const bool narrow = filter.shape == Shape::kGaussian && filter.sigma < 0.1 * filter.radius;
  if (narrow && low < -9.0 * filter.sigma) low = std::min(high, -9.0 * filter.sigma);
  if (narrow && high > 9.0 * filter.sigma) high = std::max(low, 9.0 * filter.sigma);
  constexpr std::array<double, 3> kNodes = {0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr std::array<double, 3> kWeights = {
      0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  constexpr int kCells = 400;
  const double half = 0.5 * (high - low) / kCells;
  double sum = 0.0;
  for (int cell = 0; cell < kCells; ++cell) {
    const double middle = low + (2.0 * cell + 1.0) * half;
    sum += kWeights[0] * FilterProfile(filter, middle);
    for (std::size_t i = 1; i < 3; ++i) {
      sum += kWeights[i] * (FilterProfile(filter, middle - kNodes[i] * half) +
                            FilterProfile(filter, middle + kNodes[i] * half));
    }
  }
  return sum * half;
}

/// Distribution function, split at the tent's corner.
double Below(const PixelFilter& filter, double d) {
  return d < 0.0 ? Integral(filter, -filter.radius, d)
                 : Integral(filter, -filter.radius, 0.0) + Integral(filter, 0.0, d);
}

TEST(PixelFilter, IntegratesToOneAndIsZeroOutside) {
  for (const PixelFilter& filter : AllFilters()) {
    EXPECT_NEAR(Below(filter, filter.radius), 1.0, 1e-12) << filter.radius << " " << filter.sigma;
    EXPECT_EQ(FilterProfile(filter, 1.0001 * filter.radius), 0.0);
    EXPECT_EQ(FilterProfile(filter, -1.0001 * filter.radius), 0.0);
    EXPECT_EQ(FilterProfile(filter, NAN), 0.0);
    EXPECT_EQ(FilterProfile(filter, 0.3 * filter.radius),
              FilterProfile(filter, -0.3 * filter.radius));
    if (filter.shape != Shape::kBox) {
      EXPECT_NEAR(FilterProfile(filter, filter.radius), 0.0, 1e-15) << "continuous";
    }
  }
  EXPECT_EQ(FilterProfile({Shape::kBox, 0.5, 0.0}, 0.2), 1.0);
  EXPECT_NEAR(FilterProfile({Shape::kTent, 1.0, 0.0}, 0.25), 0.75, 1e-15);
}

TEST(PixelFilter, GaussianIsTheCutAndShiftedOne) {
  const PixelFilter filter{Shape::kGaussian, 2.0, 0.5};
  const double cut = std::exp(-8.0);
  const double norm = 0.5 * std::sqrt(2.0 * M_PI) * std::erf(2.0 * M_SQRT2) - 4.0 * cut;
  for (const double d : {0.0, 0.3, -1.1, 1.99}) {
    EXPECT_NEAR(FilterProfile(filter, d), (std::exp(-2.0 * d * d) - cut) / norm, 1e-14);
  }
  // Far narrower than its Gaussian, only the parabola at the top is left.
  const PixelFilter flat{Shape::kGaussian, 1.0, 1e3};
  for (const double d : {0.0, 0.5, 0.9}) {
    EXPECT_NEAR(FilterProfile(flat, d), 0.75 * (1.0 - d * d), 1e-6);
  }
}

TEST(PixelFilter, SlopeAgreesWithDifferences) {
  for (const PixelFilter& filter : AllFilters()) {
    const double peak = FilterProfile(filter, 0.0);
    for (const double share : {-0.97, -0.5, -0.1, 0.2, 0.7}) {
      const bool narrow = filter.shape == Shape::kGaussian && filter.sigma < 0.1 * filter.radius;
      const double width = narrow ? 2.0 * filter.sigma : filter.radius;
      const double d = share * width;
      const auto along = [&](double t) { return FilterProfile(filter, t); };
      EXPECT_NEAR(FilterSlope(filter, d),
                  tests::RiddersDerivative(along, d, 0.02 * width),
                  1e-9 * peak / width);
    }
    EXPECT_EQ(FilterSlope(filter, 0.0), 0.0);
    EXPECT_EQ(FilterSlope(filter, 1.1 * filter.radius), 0.0);
  }
}

TEST(PixelFilter, SamplesInvertTheDistributionFunction) {
  for (const PixelFilter& filter : AllFilters()) {
    double last = -filter.radius;
    for (const double u :
         {0.0, 1e-16, 1e-9, 1e-4, 0.02, 0.2, 0.4999, 0.5, 0.61, 0.9, 0.999, 1 - 1e-7, 1 - 1e-16}) {
      const double d = SampleFilter(filter, u);
      EXPECT_GE(d, last) << u << " increasing";
      EXPECT_LE(d, filter.radius);
      EXPECT_NEAR(Below(filter, d), u, 2e-13) << filter.radius << " " << filter.sigma << " " << u;
      last = d;
    }
    EXPECT_EQ(SampleFilter(filter, 0.25), -SampleFilter(filter, 0.75));
    EXPECT_NEAR(SampleFilter(filter, 0.5), 0.0, 1e-15);
  }
}

/// Regular numbers in: the share of samples in each cell is the cell's integral.
TEST(PixelFilter, SamplesHaveTheProfilesDensity) {
  constexpr int kCells = 20;
  constexpr int kSamples = 40000;
  for (const PixelFilter& filter : AllFilters()) {
    std::array<int, kCells> count{};
    for (int i = 0; i < kSamples; ++i) {
      const double d = SampleFilter(filter, (i + 0.5) / kSamples);
      const int cell = static_cast<int>(kCells * 0.5 * (1.0 + d / filter.radius));
      ++count[static_cast<std::size_t>(std::min(cell, kCells - 1))];
    }
    for (int cell = 0; cell < kCells; ++cell) {
      const double low = filter.radius * (2.0 * cell / kCells - 1.0);
      const double high = filter.radius * (2.0 * (cell + 1) / kCells - 1.0);
      const double share = static_cast<double>(count[static_cast<std::size_t>(cell)]) / kSamples;
      EXPECT_NEAR(share, Below(filter, high) - Below(filter, low), 1.01 / kSamples);
    }
  }
}

double SumOfWeights(const PixelFilter& filter, double u, double v) {
  double sum = 0.0;
  ForEachCoveringPixel(filter, u, v, 40, 30, [&](int, int, double weight) { sum += weight; });
  return sum;
}

TEST(PixelFilter, WeightsOfBoxAndTentSumToOneInside) {
  for (int i = 0; i < 32; ++i) {
    const double u = 10.0 + 0.0625 * i;
    for (const double v : {11.0, 11.3, 11.5, 11.99}) {
      EXPECT_NEAR(SumOfWeights({Shape::kBox, 0.5, 0.0}, u, v), 1.0, 1e-14);
      EXPECT_NEAR(SumOfWeights({Shape::kTent, 1.0, 0.0}, u, v), 1.0, 1e-13);
      EXPECT_NEAR(SumOfWeights({Shape::kTent, 2.0, 0.0}, u, v), 1.0, 1e-13);
    }
  }
}

TEST(PixelFilter, TheBoxVisitsThePixelThatHoldsThePoint) {
  const PixelFilter box{Shape::kBox, 0.5, 0.0};
  for (const double u : {0.0, 1e-20, 0.3, 1.0 - 1e-16, 1.0, 17.5, 39.0, 40.0 - 1e-14}) {
    int visits = 0;
    ForEachCoveringPixel(box, u, 2.0, 40, 30, [&](int x, int y, double weight) {
      EXPECT_EQ(x, static_cast<int>(std::floor(u)));
      EXPECT_EQ(y, 2);
      EXPECT_EQ(weight, 1.0);
      ++visits;
    });
    EXPECT_EQ(visits, 1) << u;
  }
  for (const double u : {-1e-3, 40.0, 1e300, -1e300, static_cast<double>(NAN), HUGE_VAL}) {
    EXPECT_EQ(SumOfWeights(box, u, 2.0), 0.0) << u;
    EXPECT_EQ(SumOfWeights(box, 2.0, u), 0.0) << u;
  }
}

/// Exactly the pixels of a plain search over the film (no point lies on the border of a filter,
/// where rounding decides), each with its product of profiles.
TEST(PixelFilter, VisitsEveryPixelUnderTheFilterAlsoAtAndBeyondTheBorder) {
  for (const PixelFilter& filter : AllFilters()) {
    for (const double u : {-6.9, -1.15, 0.0, 0.7, 20.25, 39.85, 43.1}) {
      const double v = 0.6 * u + 1.3;
      std::vector<std::array<double, 3>> visited;
      ForEachCoveringPixel(filter, u, v, 40, 30, [&](int x, int y, double weight) {
        visited.push_back({1.0 * x, 1.0 * y, weight});
      });
      std::size_t next = 0;
      for (int y = 0; y < 30; ++y) {
        for (int x = 0; x < 40; ++x) {
          const double weight =
              FilterProfile(filter, u - (x + 0.5)) * FilterProfile(filter, v - (y + 0.5));
          if (weight > 0.0) {
            ASSERT_LT(next, visited.size());
            EXPECT_EQ(visited[next], (std::array<double, 3>{1.0 * x, 1.0 * y, weight}));
            ++next;
          }
        }
      }
      EXPECT_EQ(next, visited.size());
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer::pixel_filter_test
