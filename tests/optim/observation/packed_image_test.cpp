#include "optim/observation/packed_image.h"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "optim/observation/observation.h"

namespace pathfit::packed_image_test {
namespace {

using optim::PackedImage;
using renderer::Image;

Image MadeOf(int num_distinct) {
  Image image(300, 200, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] =
        std::sin(0.1F * static_cast<float>(i * 7919 % static_cast<std::size_t>(num_distinct)));
  }
  return image;
}

void ExpectBytes(const Image& image, std::size_t bytes) {
  const PackedImage packed(image);
  EXPECT_EQ(packed.MemoryBytes(), bytes);
  const Image unpacked = packed.Unpack();
  EXPECT_EQ(unpacked.width, image.width);
  EXPECT_EQ(unpacked.height, image.height);
  EXPECT_EQ(unpacked.channels, image.channels);
  ASSERT_EQ(unpacked.data.size(), image.data.size());
  EXPECT_EQ(std::memcmp(unpacked.data.data(), image.data.data(), 4 * image.data.size()), 0);
}

TEST(PackedImage, FewNumbersTakeAByteEach) {
  ExpectBytes(MadeOf(1), 4);
  ExpectBytes(MadeOf(250), 300 * 200 * 3 + 4 * 250);
  Image zeros = MadeOf(2);
  zeros.data[7] = -0.0F;  // apart from 0, which the first number is
  ExpectBytes(zeros, 300 * 200 * 3 + 4 * 3);
}

TEST(PackedImage, NumbersOfSixteenBitsTakeTwoBytes) {
  Image image(600, 200, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] = static_cast<float>(i * 40503 % 65536) / 65535.0F;
  }
  ExpectBytes(image, 2 * image.data.size() + 4 * 65536);
}

TEST(PackedImage, OthersStayFloats) {
  Image image(300, 200, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] = 1.0F / static_cast<float>(i + 1);
  }
  ExpectBytes(image, 4 * image.data.size());
  ExpectBytes(Image(), 0);
}

TEST(PackedLevel, IsTheLevelAndTakesLittleBesideItsView) {
  optim::View view;
  view.camera.width = 300;
  view.camera.height = 200;
  view.photo = MadeOf(250);
  const optim::ObservationSet set;
  for (const double scale : {1.0, 0.5, 0.25}) {
    const optim::PackedLevel level(view, set, scale);
    const optim::ViewLevel unpacked = level.Unpack();
    EXPECT_EQ(unpacked.photo.data, PackedLevel(view, set, scale).Unpack().photo.data);
    EXPECT_EQ(unpacked.color_weight.data.size(), unpacked.photo.data.size() / 3);
    EXPECT_LE(level.MemoryBytes(), static_cast<std::size_t>(300 * 200));
  }
  EXPECT_EQ(optim::PackedLevel(view, set, 1.0).MemoryBytes(), 4U);
}

}  // namespace
}  // namespace pathfit::packed_image_test
