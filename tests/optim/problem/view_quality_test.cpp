#include "optim/problem/view_quality.h"

#include <cmath>
#include <cstddef>
#include <random>

#include <gtest/gtest.h>

namespace pathfit::view_quality_test {
namespace {

TEST(ViewQuality, IsUnknownWhereNothingIsCompared) {
  optim::ViewLevel level;
  level.photo = renderer::Image(2, 2, 3);
  level.color_weight = renderer::Image(2, 2, 1);
  const renderer::Film film(2, 2);
  const optim::ViewQuality unknown = optim::MeasureView(level, film, true);
  EXPECT_TRUE(std::isnan(unknown.psnr_linear));
  EXPECT_TRUE(std::isnan(unknown.psnr_srgb));
  EXPECT_TRUE(std::isnan(unknown.iou));
  level.mask = renderer::Image(2, 2, 1);
  level.color_weight.data[0] = 1.0F;
  const optim::ViewQuality equal = optim::MeasureView(level, film, true);
  EXPECT_EQ(equal.psnr_srgb, optim::kMaxPsnr);
  EXPECT_EQ(equal.iou, 1.0);
  EXPECT_TRUE(std::isnan(optim::MeasureView(level, film, false).iou)) << "masks of data";
}

TEST(ViewQuality, IsOfTheSceneHoweverNoisyItsHalves) {
  constexpr int kSide = 100;
  constexpr double kError = 0.02, kNoise = 0.1;
  optim::ViewLevel level;
  level.photo = renderer::Image(kSide, kSide, 3);
  level.color_weight = renderer::Image(kSide, kSide, 1);
  renderer::Film a(kSide, kSide), b(kSide, kSide);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, kNoise);
  for (std::size_t p = 0; p < a.pixels.size(); ++p) {
    level.color_weight.data[p] = 1.0F;
    for (int c = 0; c < 3; ++c) {
      level.photo.data[3 * p + static_cast<std::size_t>(c)] = 0.5F;
      a.pixels[p][c] = 0.5 + kError + noise(random);
      b.pixels[p][c] = 0.5 + kError + noise(random);
    }
  }
  const double expected = -20.0 * std::log10(kError);
  // The sum's standard error is 16 % of it.
  EXPECT_NEAR(optim::MeasureView(level, a, b, false).psnr_linear, expected, 2.5);
  EXPECT_LT(optim::MeasureView(level, a, false).psnr_linear, expected - 10.0) << "of the picture";
}

TEST(ViewQuality, CountsWhatNoiseCouldHide) {
  optim::ViewLevel level;
  level.photo = renderer::Image(10, 10, 3);
  level.color_weight = renderer::Image(10, 10, 1);
  renderer::Film a(10, 10), b(10, 10);
  for (std::size_t p = 0; p < a.pixels.size(); ++p) {
    level.color_weight.data[p] = 1.0F;
    a.pixels[p].r = 0.1;
    b.pixels[p].r = p % 2 == 0 ? 0.1 : -0.1;
  }
  // Products of +-0.01, which cancel: 100 of 300 channels with a standard error of sqrt(100).
  EXPECT_NEAR(optim::MeasureView(level, a, b, false).psnr_linear,
              -10.0 * std::log10(0.01 * 10.0 / 300.0),
              1e-9);
}

}  // namespace
}  // namespace pathfit::view_quality_test
