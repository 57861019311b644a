#include "optim/problem/split_half_cost.h"

#include <cmath>
#include <cstddef>
#include <random>

#include <gtest/gtest.h>

#include "renderer/image/image.h"

namespace pathfit::optim::split_half_cost_test {
namespace {

constexpr int kSide = 64;
constexpr std::size_t kPixels = kSide * kSide;

/// Of an image of which the first `seen` pixels are `wrong` by so much, with `noise` of its own in
/// each half, to a black photo.
ImageCosts CostsOf(std::size_t seen, double wrong, double noise) {
  ViewLevel level;
  level.photo = renderer::Image(kSide, kSide, 3);
  level.mask = renderer::Image(kSide, kSide, 1);
  const RowScales scales(kPixels, {1.0F, 1.0F, 1.0F, 1.0F});
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal(0.0, 1.0);
  renderer::Film a(kSide, kSide), b(kSide, kSide);
  for (std::size_t p = 0; p < seen; ++p) {
    for (renderer::Film* film : {&a, &b}) {
      const auto channel = [&] { return wrong + noise * normal(rng); };
      film->pixels[p] = {channel(), channel(), channel(), 0.0};
    }
  }
  ImageCosts costs;
  AddSplitHalfCosts(level, scales, a, b, costs);
  return costs;
}

TEST(SplitHalfCost, UnexplainedIsWhatRemainsWhereSomethingIsSeen) {
  constexpr double kWrong = 0.1;
  const ImageCosts costs = CostsOf(kPixels / 4, kWrong, 0.0);
  EXPECT_EQ(costs.num_colors, 3.0 * kPixels / 4);
  EXPECT_NEAR(UnexplainedResidual(costs, false), kWrong, 1e-9);
  EXPECT_NEAR(UnexplainedResidual(costs, true), kWrong, 1e-9);
  EXPECT_EQ(UnexplainedResidual(CostsOf(0, kWrong, 0.0), true), 0.0);
}

TEST(SplitHalfCost, NoiseOfTheRenderingsIsUnexplainedWhereItIsNotAveraged) {
  constexpr double kWrong = 0.1, kNoise = 0.2;
  const ImageCosts costs = CostsOf(kPixels, kWrong, kNoise);
  EXPECT_NEAR(UnexplainedResidual(costs, false), kWrong, 0.1 * kWrong);
  const double both = std::sqrt(kWrong * kWrong + 0.5 * kNoise * kNoise);
  EXPECT_NEAR(UnexplainedResidual(costs, true), both, 0.05 * both);
}

}  // namespace
}  // namespace pathfit::optim::split_half_cost_test
