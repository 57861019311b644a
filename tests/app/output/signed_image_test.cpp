#include "app/output/signed_image.h"

#include <gtest/gtest.h>

namespace pathfit::app::signed_image_test {
namespace {

using renderer::Film;
using renderer::Image;

std::array<float, 3> At(const Image& image, int x, int y) {
  return {image.At(x, y, 0), image.At(x, y, 1), image.At(x, y, 2)};
}
constexpr std::array<float, 3> kBlue = {0.0F, 0.0F, 1.0F};
constexpr std::array<float, 3> kWhite = {1.0F, 1.0F, 1.0F};
constexpr std::array<float, 3> kRed = {1.0F, 0.0F, 0.0F};

/// Left half -1, right half +1, a row of zeros below.
Film Halves(int width, int height) {
  Film film(width, height);
  for (int y = 0; y + 1 < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double value = x < width / 2 ? -1.0 : 1.0;
      film.pixels[static_cast<std::size_t>(y * width + x)] = {value, value, value, 0.0};
    }
  }
  return film;
}

TEST(SignedImage, ColoursAndABarWithNumbersBelow) {
  for (const int width : {1, 16, 100, 640}) {
    const Film film = Halves(width, 8);
    const Image image = SignedImage(film, 1.0);
    ASSERT_GE(image.width, width);
    ASSERT_GT(image.height, 8);
    EXPECT_EQ(At(image, width - 1, 0), kRed);
    EXPECT_EQ(At(image, 0, 0), width > 1 ? kBlue : kRed);
    EXPECT_EQ(At(image, 0, 7), kWhite);
    // The bar runs from blue to red; black numbers stand below it.
    int bar = 8;
    while (bar < image.height && At(image, 0, bar) == kWhite) ++bar;
    ASSERT_LT(bar, image.height);
    EXPECT_LT(At(image, 0, bar)[0], 0.05F);
    EXPECT_EQ(At(image, 0, bar)[2], 1.0F);
    EXPECT_EQ(At(image, image.width - 1, bar)[0], 1.0F);
    EXPECT_LT(At(image, image.width - 1, bar)[2], 0.05F);
    int left = 0, right = 0;
    for (int y = bar; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        if (At(image, x, y) == std::array<float, 3>{}) ++(2 * x < image.width ? left : right);
      }
    }
    EXPECT_GT(left, 5);
    EXPECT_GT(right, left) << "a plus has more dots than a minus";
  }
}

TEST(SignedImage, ScaleLeavesOutliersOut) {
  Film film(100, 100);
  for (auto& p : film.pixels) p = {0.5, 0.5, 0.5, 0.0};
  film.pixels[0] = {1e6, 1e6, 1e6, 0.0};
  EXPECT_NEAR(SignedScale(film), 0.5, 1e-12);
  EXPECT_EQ(SignedScale(Film(4, 4)), 0.0);
  EXPECT_EQ(At(SignedImage(Film(4, 4), 0.0), 0, 0), kWhite);
}

}  // namespace
}  // namespace pathfit::app::signed_image_test
