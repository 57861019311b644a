#include "renderer/io/radiance_file.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/renderer/io/temporary_folder.h"

namespace pathfit::renderer {
namespace {

using std::string_literals::operator""s;

Image Read(const std::filesystem::path& path) { return DecodeHdr(ReadWholeFile(path), path); }

Image MakeImage(int width, int height) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float scale = std::pow(2.0F, static_cast<float>(x % 40) - 20.0F);
      image.At(x, y, 0) = scale * (1.0F + 0.37F * static_cast<float>(y % 5));
      image.At(x, y, 1) = x > width / 2 ? 0.5F : scale;
      image.At(x, y, 2) = 0.0F;
    }
  }
  return image;
}

TEST(RadianceFile, RoundTripIsWithinHalfAStepOfTheLargestChannel) {
  const TemporaryFolder folder;
  // Flat scan lines below 8 pixels, run-length coded ones above.
  for (const int width : {1, 7, 8, 9, 127, 128, 129, 500}) {
    const Image image = MakeImage(width, 6);
    const std::filesystem::path path = folder.Path() / "a.hdr";
    WriteHdr(path, image);
    const Image copy = Read(path);
    ASSERT_EQ(copy.width, width);
    ASSERT_EQ(copy.height, 6);
    for (int y = 0; y < 6; ++y) {
      for (int x = 0; x < width; ++x) {
        // The largest channel has at least 128 of 256 steps.
        const double step = MaxChannel(image.ColorAt(x, y)) / 128.0;
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(copy.At(x, y, c), image.At(x, y, c), 0.5 * step * (1.0 + 1e-6));
        }
      }
    }
  }
}

TEST(RadianceFile, KeepsExactValuesAndRoundsUpToTheNextExponent) {
  Image image(2, 1, 3);
  image.data = {1.0F, 0.5F, 0.0F, 0.9999F, 0.25F, 0.0F};
  const TemporaryFolder folder;
  WriteHdr(folder.Path() / "a.hdr", image);
  const Image copy = Read(folder.Path() / "a.hdr");
  EXPECT_EQ(copy.data, (std::vector<float>{1.0F, 0.5F, 0.0F, 1.0F, 0.25F, 0.0F}));
}

TEST(RadianceFile, ReadsTurnedImagesAndExposure) {
  const std::string pixels = "\x80\x00\x00\x81\x00\x80\x00\x81"s;  // red 1, then green 1
  const auto decode = [&](const std::string& size) {
    return DecodeHdr("#?RADIANCE\nEXPOSURE=4\nFORMAT=32-bit_rle_rgbe\n\n" + size + "\n" + pixels,
                     "a");
  };
  const Image row = decode("-Y 1 +X 2");
  EXPECT_EQ(row.At(0, 0, 0), 0.25F);
  EXPECT_EQ(row.At(1, 0, 1), 0.25F);
  EXPECT_EQ(decode("-Y 1 -X 2").At(1, 0, 0), 0.25F);
  EXPECT_EQ(decode("+Y 2 +X 1").At(0, 1, 0), 0.25F);
  const Image column = decode("+X 1 -Y 2");
  EXPECT_EQ(column.height, 2);
  EXPECT_EQ(column.At(0, 0, 0), 0.25F);
  EXPECT_EQ(column.At(0, 1, 1), 0.25F);
}

TEST(RadianceFile, RefusesMalformedFiles) {
  const std::string header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
  const std::pair<std::string, std::string> cases[] = {
      {"P6", "must begin with"},
      {"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n", "32-bit_rle_rgbe"},
      {"#?RADIANCE\nEXPOSURE=-1\n\n", "EXPOSURE must be positive"},
      {"#?RADIANCE\n", "has no end"},
      {header, "the size is missing"},
      {header + "-Y 2\n", "the size must look like"},
      {header + "-Y 2 +Y 2\n", "the size must look like"},
      {header + "-Y 0 +X 2\n", "image size 2 x 0"},
      {header + "-Y 900000000 +X 900000000\n", "is not allowed"},
      {header + "-Y 10000 +X 10000\n\x02\x02", "ends too early"},
      {header + "-Y 1 +X 8\n\x02\x02\x00\x09" + std::string(40, '\x01'), "another length"},
      {header + "-Y 1 +X 8\n\x02\x02\x00\x08"s + std::string(40, '\xff'), "does not fit"},
      {header + "-Y 1 +X 8\n\x02\x02\x00\x08"s + std::string(40, '\0'), "does not fit"},
      {header + "-Y 1 +X 2\n\x01\x01\x01\x01\x01\x01\x01\x01"s, "before 1991"},
  };
  for (const auto& [bytes, message] : cases) {
    const std::string got = IoErrorOf([&bytes = bytes] { DecodeHdr(bytes, "a.hdr"); });
    EXPECT_NE(got.find(message), std::string::npos) << got << "\nwanted " << message;
  }
}

TEST(RadianceFile, RefusesToWriteWhatItCannotHold) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "a.hdr";
  Image image = MakeImage(3, 3);
  image.data[4] = -1.0F;
  EXPECT_THROW(WriteHdr(path, image), IoError);
  image.data[4] = HUGE_VALF;
  EXPECT_THROW(WriteHdr(path, image), NumericalError);
  image.data[4] = 3e38F;
  EXPECT_THROW(WriteHdr(path, image), IoError);
  EXPECT_THROW(WriteHdr(path, Image(2, 2, 1)), IoError);
}

TEST(RadianceFile, SurvivesCutAndDamagedFiles) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "a.hdr";
  for (const int width : {5, 60}) {
    WriteHdr(path, MakeImage(width, 5));
    ExpectCutFilesRefused(path, ReadWholeFile(path).size(), 150, Read);
    ExpectDamagedFilesSurvived(path, 200, Read);
  }
}

}  // namespace
}  // namespace pathfit::renderer
