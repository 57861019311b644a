#include "renderer/io/exr_file.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticities.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "tests/renderer/io/temporary_folder.h"

namespace pathfit::renderer::exr_file_test {
namespace {

Image MakeImage(int width, int height, int channels) {
  Image image(width, height, channels);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] = std::sin(static_cast<float>(i)) * 1e3F;
  }
  return image;
}

/// File with half channels of the given names whose values are x + 10 y, from the data window's
/// corner.
void WriteHalf(const std::filesystem::path& path, const std::vector<std::string>& names) {
  const Imath::Box2i window({-2, 5}, {4, 9});
  Imf::Header header({{0, 0}, {99, 99}}, window);
  std::vector<Imath::half> pixels;
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x) pixels.emplace_back(static_cast<float>(x + 10 * y));
  }
  Imf::FrameBuffer buffer;
  for (const std::string& name : names) {
    header.channels().insert(name, Imf::Channel(Imf::HALF));
    buffer.insert(name, Imf::Slice::Make(Imf::HALF, pixels.data(), window, 2, 14));
  }
  Imf::OutputFile file(path.string().c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(5);
}

TEST(ExrFile, RoundTripIsExact) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "a.exr";
  const Image color = MakeImage(37, 150, 3);
  WriteExr(path, color);
  Image alpha(1, 1, 1);
  EXPECT_EQ(ReadExr(path, &alpha).data, color.data);
  EXPECT_TRUE(alpha.Empty());

  const Image rgba = MakeImage(5, 4, 4);
  WriteExr(path, rgba);
  const Image rgb = ReadExr(path, &alpha);
  EXPECT_EQ(rgb.channels, 3);
  ASSERT_EQ(alpha.data.size(), 20U);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 5; ++x) {
      for (int c = 0; c < 3; ++c) EXPECT_EQ(rgb.At(x, y, c), rgba.At(x, y, c));
      EXPECT_EQ(alpha.At(x, y, 0), rgba.At(x, y, 3));
    }
  }

  const Image gray = MakeImage(3, 2, 1);
  WriteExr(path, gray);
  const Image repeated = ReadExr(path);
  for (std::size_t i = 0; i < repeated.data.size(); ++i) {
    EXPECT_EQ(repeated.data[i], gray.data[i / 3]);
  }
}

TEST(ExrFile, ReadsHalfAndAnyDataWindow) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "a.exr";
  for (const auto& names : {std::vector<std::string>{"R", "G", "B", "Z"}, {"Y"}}) {
    WriteHalf(path, names);
    const Image image = ReadExr(path);
    ASSERT_EQ(image.width, 7);
    ASSERT_EQ(image.height, 5);
    ASSERT_EQ(image.channels, 3);
    EXPECT_EQ(image.At(3, 2, 1), 23.0F);
    EXPECT_EQ(image.At(6, 4, 2), 46.0F);
  }
}

TEST(ExrFile, ReadsTiles) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "a.exr";
  const Image image = MakeImage(45, 70, 3);
  Imf::Header header(45, 70);
  header.setTileDescription(Imf::TileDescription(16, 16, Imf::ONE_LEVEL));
  Imf::FrameBuffer buffer;
  std::vector<float> pixels = image.data;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::string name(1, "RGB"[c]);
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    buffer.insert(
        name, Imf::Slice::Make(Imf::FLOAT, pixels.data() + c, header.dataWindow(), 12, 45 * 12));
  }
  {
    Imf::TiledOutputFile file(path.string().c_str(), header);
    file.setFrameBuffer(buffer);
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  }
  EXPECT_EQ(ReadExr(path).data, image.data);
}

TEST(ExrFile, RefusesWrongChannelsAndNumbers) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "a.exr";
  WriteHalf(path, {"R", "G"});
  EXPECT_NE(IoErrorOf([&] { ReadExr(path); }).find("allowed channels are R G B or Y"),
            std::string::npos);
  Image image = MakeImage(4, 3, 3);
  image.At(2, 1, 0) = std::numeric_limits<float>::quiet_NaN();
  try {
    WriteExr(path, image);
    ADD_FAILURE();
  } catch (const NumericalError& error) {
    EXPECT_NE(std::string(error.what()).find("pixel (2, 1)"), std::string::npos);
  }
  EXPECT_THROW(WriteExr(path, Image()), IoError);
  EXPECT_THROW(WriteExr(path, Image(2, 2, 2)), IoError);
  EXPECT_THROW(WriteExr(folder.Path() / "no" / "a.exr", MakeImage(2, 2, 3)), IoError);
  EXPECT_THROW(ReadExr(folder.Path() / "none.exr"), IoError);
  EXPECT_THROW(ReadExr(folder.Path()), IoError);
  EXPECT_THROW(ReadExr(folder.Write("text.exr", "hello")), IoError);
}

TEST(ExrFile, RefusesColoursOfOtherPrimaries) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "a.exr";
  const auto write = [&](const std::string& names, const Imf::Chromaticities& chromaticities) {
    Imf::Header header(2, 2);
    Imf::addChromaticities(header, chromaticities);
    std::vector<float> pixels(12, 0.5F);
    Imf::FrameBuffer buffer;
    for (const char c : names) {
      const std::string name(1, c);
      header.channels().insert(name, Imf::Channel(Imf::FLOAT));
      buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, pixels.data(), header.dataWindow(), 12, 24));
    }
    Imf::OutputFile file(path.string().c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(2);
  };
  write("RGB", Imf::Chromaticities());
  EXPECT_EQ(ReadExr(path).At(1, 1, 2), 0.5F);
  const Imf::Chromaticities acescg(
      {0.713F, 0.293F}, {0.165F, 0.83F}, {0.128F, 0.044F}, {0.32168F, 0.33767F});
  write("RGB", acescg);
  const std::string message = IoErrorOf([&] { ReadExr(path); });
  EXPECT_NE(message.find("red 0.713000 0.293000"), std::string::npos) << message;
  EXPECT_NE(message.find("convert its colours to linear Rec.709"), std::string::npos);
  write("Y", acescg);  // grey has none
  EXPECT_EQ(ReadExr(path).At(1, 1, 2), 0.5F);
}

TEST(ExrFile, RefusesAnInfinitePixel) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "a.exr";
  Imf::Header header(1, 1, 1.0F, {0, 0}, 1.0F, Imf::INCREASING_Y, Imf::NO_COMPRESSION);
  header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
  float value = HUGE_VALF;
  {
    Imf::FrameBuffer buffer;
    buffer.insert("Y", Imf::Slice::Make(Imf::FLOAT, &value, header.dataWindow(), 4, 4));
    Imf::OutputFile file(path.string().c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(1);
  }
  EXPECT_NE(IoErrorOf([&] { ReadExr(path); }).find("pixel (0, 0) is not finite"),
            std::string::npos);
}

TEST(ExrFile, RefusesSizesThatTheFileCannotHold) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "a.exr";
  WriteExr(path, MakeImage(4, 4, 3));
  std::string bytes = ReadWholeFile(path);
  for (const char* window : {"dataWindow", "displayWindow"}) {
    const std::size_t at = bytes.find(window);
    ASSERT_NE(at, std::string::npos);
    // name, box2i, size; then from x, y to x, y.
    const std::size_t corner = bytes.find("box2i", at) + 6 + 4 + 8;
    bytes.replace(corner, 8, std::string("\xff\x3f\0\0\xff\x3f\0\0", 8));
  }
  const std::string message = IoErrorOf([&] { ReadExr(folder.Write("b.exr", bytes)); });
  EXPECT_NE(message.find("b.exr"), std::string::npos) << message;
}

TEST(ExrFile, SurvivesCutAndDamagedFiles) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "a.exr";
  const auto read = [](const std::filesystem::path& file) { ReadExr(file); };
  WriteExr(path, MakeImage(21, 40, 3));
  ExpectCutFilesRefused(path, ReadWholeFile(path).size(), 100, read);
  ExpectDamagedFilesSurvived(path, 200, read);
}

}  // namespace
}  // namespace pathfit::renderer::exr_file_test
