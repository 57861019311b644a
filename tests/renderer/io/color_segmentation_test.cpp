#include "renderer/io/color_segmentation.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "renderer/core/error.h"

namespace pathfit::renderer::color_segmentation_test {
namespace {

constexpr int kSize = 40;

/// A red disk of radius 10 before green.
Image Disk() {
  Image image(kSize, kSize, 3);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const bool inside = std::hypot(x - 20.0, y - 20.0) < 10.0;
      image.At(x, y, 0) = inside ? 0.8F : 0.1F;
      image.At(x, y, 1) = inside ? 0.1F : 0.6F;
      image.At(x, y, 2) = 0.05F * static_cast<float>((x + y) % 2);
    }
  }
  return image;
}

std::vector<ObjectHint> MiddleIsObject() {
  std::vector<ObjectHint> hints(kSize * kSize, ObjectHint::kMaybeBackground);
  for (int i = 0; i < kSize; ++i) {
    hints[static_cast<std::size_t>(i)] = ObjectHint::kBackground;
  }
  for (int y = 17; y < 23; ++y) {
    for (int x = 17; x < 23; ++x) {
      hints[static_cast<std::size_t>(y * kSize + x)] = ObjectHint::kMaybeObject;
    }
  }
  return hints;
}

TEST(SegmentByColor, GrowsFromHintsToTheEdgeOfTheColour) {
  const Image image = Disk();
  const Image found = SegmentByColor(image, MiddleIsObject(), 4);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      EXPECT_EQ(found.At(x, y, 0) > 0.5F, image.At(x, y, 0) > 0.5F) << x << ", " << y;
    }
  }
}

TEST(SegmentByColor, KeepsWhatIsKnown) {
  std::vector<ObjectHint> hints = MiddleIsObject();
  hints[5 * kSize + 5] = ObjectHint::kObject;
  hints[20 * kSize + 20] = ObjectHint::kBackground;
  const Image found = SegmentByColor(Disk(), hints, 2);
  EXPECT_EQ(found.At(5, 5, 0), 1.0F);
  EXPECT_EQ(found.At(20, 20, 0), 0.0F);
  const auto sum = [](const Image& mask) {
    double total = 0.0;
    for (const float value : mask.data) total += static_cast<double>(value);
    return total;
  };
  std::ranges::fill(hints, ObjectHint::kMaybeObject);
  EXPECT_EQ(sum(SegmentByColor(Disk(), hints, 2)), kSize * kSize);
  std::ranges::fill(hints, ObjectHint::kMaybeBackground);
  EXPECT_EQ(sum(SegmentByColor(Disk(), hints, 2)), 0.0);
}

TEST(SegmentByColor, RefusesOtherImages) {
  EXPECT_THROW(SegmentByColor(Image(), {}, 2), IoError);
  EXPECT_THROW(SegmentByColor(Image(2, 2, 1), std::vector<ObjectHint>(4), 2), IoError);
}

TEST(LargestPart, IsConnectedBySides) {
  Image mask(6, 4, 1);
  for (const int x : {0, 1, 2}) mask.At(x, 0, 0) = 0.9F;
  mask.At(3, 1, 0) = 1.0F;  // touches the first part by a corner only
  mask.At(4, 1, 0) = 1.0F;
  const Image largest = LargestPart(mask, 0.0);
  EXPECT_EQ(largest.At(2, 0, 0), 1.0F);
  EXPECT_EQ(largest.At(3, 1, 0), 0.0F);
  EXPECT_EQ(std::ranges::count(largest.data, 1.0F), 3);
  EXPECT_EQ(std::ranges::count(LargestPart(Image(3, 3, 1), 1.0).data, 0.0F), 9);
}

TEST(PartsWithin, AreThoseThatAreExpected) {
  Image mask(20, 10, 1), expected(20, 10, 1);
  const auto fill = [](int x0, int x1, Image& image) {
    for (int y = 2; y < 8; ++y) {
      for (int x = x0; x < x1; ++x) image.At(x, y, 0) = 1.0F;
    }
  };
  fill(0, 8, mask);
  fill(9, 12, mask);
  fill(13, 16, mask);
  mask.At(18, 5, 0) = 1.0F;  // less than a twentieth
  fill(10, 14, expected);
  expected.At(18, 5, 0) = 1.0F;
  const Image parts = PartsWithin(mask, expected, 0.0);
  EXPECT_EQ(parts.At(4, 5, 0), 1.0F) << "the largest";
  EXPECT_EQ(parts.At(9, 5, 0), 1.0F) << "two thirds of it are expected";
  EXPECT_EQ(parts.At(13, 5, 0), 0.0F) << "one third is";
  EXPECT_EQ(parts.At(18, 5, 0), 0.0F);
  EXPECT_THROW(PartsWithin(mask, Image(10, 10, 1), 0.0), IoError);
}

TEST(LargestPart, HasNoSmallHoles) {
  Image mask(12, 12, 1);
  std::ranges::fill(mask.data, 1.0F);
  mask.At(0, 5, 0) = 0.0F;  // at the border: outside, not a hole
  mask.At(3, 3, 0) = 0.0F;
  for (const int x : {6, 7, 8}) mask.At(x, 8, 0) = 0.0F;
  const Image filled = LargestPart(mask, 2.0 / 139.0);
  EXPECT_EQ(filled.At(3, 3, 0), 1.0F);
  EXPECT_EQ(filled.At(7, 8, 0), 0.0F);
  EXPECT_EQ(filled.At(0, 5, 0), 0.0F);
}

}  // namespace
}  // namespace pathfit::renderer::color_segmentation_test
