#include "renderer/io/texture_file.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/image/color.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/image_file.h"
#include "tests/renderer/io/temporary_folder.h"

namespace pathfit::renderer::texture_file_test {
namespace {

/// Multiples of 1/255, different everywhere.
Image MakeImage() {
  Image image(3, 2, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] = static_cast<float>(14 * i) / 255.0F;
  }
  return image;
}

TEST(ReadTexture, DecodesColorsOfIntegerFiles) {
  const TemporaryFolder folder;
  const Image image = MakeImage();
  WritePng8(folder.Path() / "paper.png", image);
  const Texture texture = ReadTexture(folder.Path() / "paper.png", TextureRole::kColor);
  EXPECT_EQ(texture.name, "paper.png");
  EXPECT_EQ(texture.width, 3);
  EXPECT_EQ(texture.height, 2);
  EXPECT_EQ(texture.wrap, TextureWrap::kRepeat);
  EXPECT_FALSE(texture.scalar);
  ASSERT_EQ(texture.texels.size(), 6U);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    const auto encoded = static_cast<double>(image.data[i]);
    EXPECT_EQ(texture.texels[i / 3][static_cast<int>(i % 3)], LinearFromSrgb(encoded));
  }
  // v runs up: the first row is on top.
  EXPECT_EQ(TextureValue(texture, {0.5 / 3, 0.75}), texture.texels[0]);
}

TEST(ReadTexture, TakesTheFirstChannelOfDataAsItIs) {
  const TemporaryFolder folder;
  const Image image = MakeImage();
  WritePng8(folder.Path() / "worn.png", image);
  const Texture texture = ReadTexture(folder.Path() / "worn.png", TextureRole::kData);
  EXPECT_TRUE(texture.scalar);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(texture.texels[i], Rgb::Constant(static_cast<double>(image.data[3 * i])));
  }
}

TEST(ReadTexture, TakesFloatsAsTheyAre) {
  const TemporaryFolder folder;
  Image image = MakeImage();
  image.At(1, 1, 2) = 13.5F;
  WriteExr(folder.Path() / "sky.exr", image);
  const Texture color = ReadTexture(folder.Path() / "sky.exr", TextureRole::kColor);
  const Texture data = ReadTexture(folder.Path() / "sky.exr", TextureRole::kData);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) {
      const auto i = static_cast<std::size_t>(3 * y + x);
      EXPECT_EQ(color.texels[i], image.ColorAt(x, y));
      EXPECT_EQ(data.texels[i], Rgb::Constant(image.ColorAt(x, y).r));
    }
  }
}

TEST(ReadTexture, ReadsGreyAndJpegFiles) {
  const TemporaryFolder folder;
  Image grey(4, 4, 1);
  for (float& value : grey.data) value = 102.0F / 255.0F;
  const std::vector<unsigned char> jpeg = EncodeJpeg(grey, 100);
  const std::string bytes(jpeg.begin(), jpeg.end());
  const Texture texture = ReadTexture(folder.Write("a.jpg", bytes), TextureRole::kColor);
  EXPECT_EQ(texture.texels[5].r, texture.texels[5].b);
  EXPECT_NEAR(texture.texels[5].r, LinearFromSrgb(0.4), 1.5 / 255.0);
}

TEST(ReadTexture, RefusesNegativeValuesAndBadFilesByName) {
  const TemporaryFolder folder;
  Image image = MakeImage();
  image.At(2, 1, 0) = -0.5F;
  WriteExr(folder.Path() / "bad.exr", image);
  for (const TextureRole role : {TextureRole::kColor, TextureRole::kData}) {
    const std::string got = IoErrorOf([&] { ReadTexture(folder.Path() / "bad.exr", role); });
    EXPECT_NE(got.find("bad.exr: pixel (2, 1) is negative"), std::string::npos) << got;
  }
  EXPECT_THROW(ReadTexture(folder.Path() / "none.png", TextureRole::kColor), IoError);
  EXPECT_THROW(ReadTexture(folder.Write("text.png", "hello"), TextureRole::kData), IoError);
}

}  // namespace
}  // namespace pathfit::renderer::texture_file_test
