#include "renderer/image/image.h"

#include <gtest/gtest.h>

namespace pathfit::renderer::image_test {
namespace {

TEST(Image, IsInterleavedRowByRow) {
  Image image(3, 2, 3);
  image.At(2, 1, 1) = 7.0F;
  EXPECT_EQ(image.data[(1 * 3 + 2) * 3 + 1], 7.0F);
  EXPECT_EQ(image.ColorAt(2, 1), (Rgb{0, 7, 0}));
  EXPECT_TRUE(Image().Empty());
  EXPECT_FALSE(image.Empty());
}

TEST(Film, SplitsIntoColorAndCoverage) {
  Film film(2, 1);
  film.pixels[1] = {0.1, 0.2, 0.3, 0.75};
  const Image color = ColorImage(film);
  const Image coverage = CoverageImage(film);
  EXPECT_EQ(color.channels, 3);
  EXPECT_EQ(coverage.channels, 1);
  EXPECT_EQ(color.At(1, 0, 2), 0.3F);
  EXPECT_EQ(coverage.At(1, 0, 0), 0.75F);
  EXPECT_EQ(coverage.At(0, 0, 0), 0.0F);
}

TEST(Rgba, KeepsRadianceAndCoverageApart) {
  Rgba x(Rgb{1, 2, 3}, 0.5);
  x += Rgba(1, 1, 1, 0.25);
  EXPECT_EQ(x, Rgba(2, 3, 4, 0.75));
  EXPECT_EQ((x - Rgba(1, 1, 1, 0.5)) * 2.0, Rgba(2, 4, 6, 0.5));
  EXPECT_EQ(x[3], 0.75);
}

}  // namespace
}  // namespace pathfit::renderer::image_test
