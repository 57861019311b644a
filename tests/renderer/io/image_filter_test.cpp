#include "renderer/io/image_filter.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "renderer/core/error.h"

namespace pathfit::renderer::image_filter_test {
namespace {

Image MakeImage(int width, int height, int channels) {
  Image image(width, height, channels);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] = static_cast<float>((i * 7919) % 101) / 10.0F;
  }
  return image;
}

/// Disc of pixels whose centres lie within `radius` of the centre of the image.
Image MakeDisc(int size, double radius) {
  Image mask(size, size, 1);
  const double center = (size - 1) / 2.0;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      mask.At(x, y, 0) = std::hypot(x - center, y - center) <= radius ? 1.0F : 0.0F;
    }
  }
  return mask;
}

TEST(ImageFilter, ResizeByAFactorAveragesBlocks) {
  const Image image = MakeImage(12, 6, 3);
  const Image half = ResizeArea(image, 4, 3);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 4; ++x) {
      for (int c = 0; c < 3; ++c) {
        double sum = 0.0;
        for (int j = 0; j < 2; ++j) {
          for (int i = 0; i < 3; ++i) sum += static_cast<double>(image.At(3 * x + i, 2 * y + j, c));
        }
        EXPECT_NEAR(half.At(x, y, c), sum / 6.0, 1e-6);
      }
    }
  }
}

TEST(ImageFilter, ResizeKeepsTheMeanForAnySize) {
  const Image image = MakeImage(17, 11, 1);
  const auto mean = [](const Image& i) {
    return std::accumulate(i.data.begin(), i.data.end(), 0.0) / static_cast<double>(i.data.size());
  };
  for (const auto& [width, height] :
       {std::pair{5, 4}, {16, 10}, {17, 3}, {34, 22}, {23, 50}, {1, 1}, {1, 40}}) {
    const Image resized = ResizeArea(image, width, height);
    ASSERT_EQ(resized.width, width);
    ASSERT_EQ(resized.height, height);
    EXPECT_NEAR(mean(resized), mean(image), 1e-6);
  }
  EXPECT_EQ(ResizeArea(image, 17, 11).data, image.data);
}

TEST(ImageFilter, ResizeSharesPixelsByArea) {
  Image image(3, 1, 1);
  image.data = {1, 10, 100};
  EXPECT_EQ(ResizeArea(image, 2, 1).data, (std::vector<float>{4, 70}));
  Image two(2, 1, 1);
  two.data = {0, 3};
  const Image three = ResizeArea(two, 3, 1);
  EXPECT_NEAR(three.data[0], 0.0F, 1e-6F);
  EXPECT_NEAR(three.data[1], 1.5F, 1e-6F);
  EXPECT_NEAR(three.data[2], 3.0F, 1e-6F);
  EXPECT_THROW(ResizeArea(image, 0, 1), IoError);
  EXPECT_THROW(ResizeArea(Image(), 1, 1), IoError);
  EXPECT_THROW(ResizeArea(image, 1 << 20, 1 << 20), IoError);
}

TEST(ImageFilter, SignedDistanceIsZeroBetweenPixels) {
  Image mask(6, 3, 1);
  for (int y = 0; y < 3; ++y) {
    for (int x = 2; x < 6; ++x) mask.At(x, y, 0) = 0.8F;
  }
  const Image distance = SignedDistanceToMask(mask);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 6; ++x) EXPECT_FLOAT_EQ(distance.At(x, y, 0), static_cast<float>(x) - 1.5F);
  }
}

TEST(ImageFilter, SignedDistanceOfADiscFollowsItsRadius) {
  const Image distance = SignedDistanceToMask(MakeDisc(81, 25.0));
  for (int y = 0; y < 81; ++y) {
    for (int x = 0; x < 81; ++x) {
      EXPECT_NEAR(distance.At(x, y, 0), 25.0 - std::hypot(x - 40, y - 40), 1.0);
    }
  }
}

TEST(ImageFilter, MasksOfOneKindAreFarFromABoundary) {
  Image mask(4, 3, 1);
  EXPECT_EQ(SignedDistanceToMask(mask).data, std::vector<float>(12, -7.0F));
  std::fill(mask.data.begin(), mask.data.end(), 1.0F);
  EXPECT_EQ(SignedDistanceToMask(mask).data, std::vector<float>(12, 7.0F));
  EXPECT_THROW(SignedDistanceToMask(Image()), IoError);
  EXPECT_THROW(SignedDistanceToMask(Image(2, 2, 3)), IoError);
}

TEST(ImageFilter, ErodeEqualsTheDefinition) {
  Image mask = MakeDisc(31, 12.3);
  for (int x = 0; x < 31; ++x) mask.At(x, 15, 0) = 0.6F;  // reaches the border
  for (const int px : {0, 1, 2, 5, 40}) {
    const Image eroded = Erode(mask, px);
    for (int y = 0; y < 31; ++y) {
      for (int x = 0; x < 31; ++x) {
        bool all_inside = true;
        for (int v = 0; v < 31; ++v) {
          for (int u = 0; u < 31; ++u) {
            const bool near = (u - x) * (u - x) + (v - y) * (v - y) <= px * px;
            all_inside = all_inside && (!near || mask.At(u, v, 0) > 0.5F);
          }
        }
        EXPECT_EQ(eroded.At(x, y, 0), all_inside ? 1.0F : 0.0F) << x << " " << y << " by " << px;
      }
    }
  }
  EXPECT_THROW(Erode(mask, -1), IoError);
  Image full(3, 3, 1);
  std::fill(full.data.begin(), full.data.end(), 1.0F);
  EXPECT_EQ(Erode(full, 100).data, full.data);
}

}  // namespace
}  // namespace pathfit::renderer::image_filter_test
