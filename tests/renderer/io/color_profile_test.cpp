#include "renderer/io/color_profile.h"

#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include <gtest/gtest.h>
#include <lcms2.h>

#include "renderer/core/error.h"
#include "renderer/image/color.h"
#include "renderer/io/image_check.h"
#include "renderer/io/image_file.h"
#include "tests/renderer/io/icc_bytes.h"
#include "tests/renderer/io/temporary_folder.h"

namespace pathfit::renderer::color_profile_test {
namespace {

using std::string_literals::operator""s;

Image OnePixel(float r, float g, float b) {
  Image image(1, 1, 3);
  image.data = {r, g, b};
  return image;
}

void ExpectColor(const Image& image, const Rgb& color, double tolerance) {
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(static_cast<double>(image.At(0, 0, c)), color[c], tolerance) << "channel " << c;
  }
}

/// In two segments, the second first.
std::string JpegWith(const std::string& icc, const Image& image) {
  const std::string jpeg = BytesOf(EncodeJpeg(image, 100));
  std::string segments;
  for (const int part : {2, 1}) {
    const std::size_t half = icc.size() / 2;
    const std::string payload = "ICC_PROFILE\0"s + static_cast<char>(part) + '\2' +
                                (part == 1 ? icc.substr(0, half) : icc.substr(half));
    segments += "\xff\xe2" + BigEndian(payload.size() + 2, 2) + payload;
  }
  return jpeg.substr(0, 2) + segments + jpeg.substr(2);
}

/// One pixel of 8 bits.
std::string TiffWith(const std::string& icc, const std::array<unsigned char, 3>& color) {
  struct Entry {
    int tag, type;
    std::size_t count, value;
  };
  constexpr std::size_t kEntries = 10, kDirectory = 8 + 2 + 12 * kEntries + 4;
  const std::array<Entry, kEntries> entries = {{{0x100, 3, 1, 1},
                                                {0x101, 3, 1, 1},
                                                {0x102, 3, 3, kDirectory},
                                                {0x103, 3, 1, 1},
                                                {0x106, 3, 1, 2},
                                                {0x111, 4, 1, kDirectory + 6},
                                                {0x115, 3, 1, 3},
                                                {0x116, 3, 1, 1},
                                                {0x117, 4, 1, 3},
                                                {0x8773, 7, icc.size(), kDirectory + 9}}};
  std::string tiff = "MM\0*"s + BigEndian(8, 4) + BigEndian(kEntries, 2);
  for (const Entry& entry : entries) {
    tiff += BigEndian(static_cast<std::size_t>(entry.tag), 2) +
            BigEndian(static_cast<std::size_t>(entry.type), 2) + BigEndian(entry.count, 4);
    const bool is_short = entry.type == 3 && entry.count == 1;
    tiff += is_short ? BigEndian(entry.value, 2) + "\0\0"s : BigEndian(entry.value, 4);
  }
  tiff += BigEndian(0, 4) + BigEndian(8, 2) + BigEndian(8, 2) + BigEndian(8, 2);
  for (const unsigned char c : color) tiff += static_cast<char>(c);
  return tiff + icc;
}

TEST(ColorProfile, SrgbIsRecognised) {
  EXPECT_TRUE(ColorProfile(RgbProfile(kRec709), "a.jpg").IsSrgb());
  EXPECT_TRUE(ColorProfile(SavedProfile(cmsCreate_sRGBProfile()), "a.jpg").IsSrgb());
  EXPECT_FALSE(ColorProfile(RgbProfile(kP3), "a.jpg").IsSrgb());
  EXPECT_FALSE(ColorProfile(RgbProfile(kRec709, 1.8), "a.jpg").IsSrgb());
  EXPECT_FALSE(ColorProfile(RgbProfile(kRec709, 1.0), "a.jpg").IsSrgb());
}

// SMPTE EG 432-1 to Rec.709, both with D65: the matrix of their chromaticities.
TEST(ColorProfile, MakesDisplayP3Linear) {
  const ColorProfile profile(RgbProfile(kP3), "a.jpg");
  Image image = OnePixel(0.8F, 0.6F, 0.4F);
  const double r = LinearFromSrgb(0.8), g = LinearFromSrgb(0.6), b = LinearFromSrgb(0.4);
  profile.MakeLinear(image);
  ExpectColor(image,
              {1.22494 * r - 0.22494 * g,
               -0.04206 * r + 1.04206 * g,
               -0.01964 * r - 0.07864 * g + 1.09827 * b},
              2e-4);
  Image red = OnePixel(1.0F, 0.0F, 0.0F);
  profile.MakeLinear(red);
  ExpectColor(red, {1.22494, 0.0, 0.0}, 1e-3);
  Image white = OnePixel(1.0F, 1.0F, 1.0F);
  profile.MakeLinear(white);
  ExpectColor(white, {1.0, 1.0, 1.0}, 2e-4);
}

// To Rec.709, both with D65: the matrix of their chromaticities.
TEST(ColorProfile, MakesAdobeRgbLinear) {
  const ColorProfile profile = ColorProfile::AdobeRgb();
  EXPECT_FALSE(profile.IsSrgb());
  Image image = OnePixel(0.8F, 0.6F, 0.4F);
  const auto linear = [](double encoded) { return std::pow(encoded, 563.0 / 256.0); };
  const double r = linear(0.8), g = linear(0.6), b = linear(0.4);
  profile.MakeLinear(image);
  ExpectColor(image, {1.39836 * r - 0.39836 * g, g, -0.04293 * g + 1.04293 * b}, 2e-4);
}

TEST(ColorProfile, TakesCurvesOfRgbAndOfGrey) {
  Image image = OnePixel(0.5F, 0.25F, 0.75F);
  ColorProfile(RgbProfile(kRec709, 1.0), "a.tif").MakeLinear(image);
  ExpectColor(image, {0.5, 0.25, 0.75}, 2e-4);
  const cmsCIExyY white = {0.3457, 0.3585, 1.0};
  cmsToneCurve* curve = cmsBuildGamma(nullptr, 2.2);
  const std::string grey = SavedProfile(cmsCreateGrayProfile(&white, curve));
  cmsFreeToneCurve(curve);
  Image dim = OnePixel(0.5F, 0.5F, 0.25F);
  ColorProfile(grey, "a.jpg").MakeLinear(dim);
  const double linear = std::pow(0.5, 2.2);
  ExpectColor(dim, {linear, linear, std::pow(0.25, 2.2)}, 1e-3);
}

TEST(ColorProfile, RefusesWhatIsNone) {
  EXPECT_THROW(ColorProfile("no profile", "a.jpg"), IoError);
  EXPECT_THROW(ColorProfile(RgbProfile(kP3).substr(0, 200), "a.jpg"), IoError);
  try {
    const ColorProfile lab(SavedProfile(cmsCreateLab4Profile(nullptr)), "a.jpg");
    FAIL() << "Lab is no colour space of photos";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("neither of RGB nor of grey"), std::string::npos)
        << error.what();
  }
}

TEST(ColorProfile, IsFoundInJpegPngAndTiff) {
  const TemporaryFolder folder;
  const std::string icc = RgbProfile(kP3);
  const Image image = OnePixel(1.0F, 0.0F, 0.0F);
  EXPECT_EQ(ReadImageFile(folder.Write("a.jpg", JpegWith(icc, image)), false).icc, icc);
  EXPECT_EQ(ReadImageFile(folder.Write("a.png", PngWith(icc, image)), false).icc, icc);
  const DecodedImage tiff = ReadImageFile(folder.Write("a.tif", TiffWith(icc, {255, 0, 0})), false);
  EXPECT_EQ(tiff.icc, icc);
  ExpectColor(tiff.image, {1.0, 0.0, 0.0}, 0.0);
  EXPECT_EQ(ReadImageFile(folder.Write("b.png", BytesOf(EncodePng(image))), false).icc, "");
}

TEST(ColorProfile, DamagedContainersHaveNone) {
  const std::string icc = RgbProfile(kP3);
  const Image image = OnePixel(1.0F, 0.0F, 0.0F);
  for (const auto& [kind, bytes] : {std::pair{ImageKind::kJpeg, JpegWith(icc, image)},
                                    std::pair{ImageKind::kPng, PngWith(icc, image)},
                                    std::pair{ImageKind::kTiff, TiffWith(icc, {1, 2, 3})}}) {
    for (std::size_t size = 0; size < bytes.size(); size += 7) {
      IccProfileOf(std::string_view(bytes).substr(0, size), kind);
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer::color_profile_test
