#include "renderer/io/image_file.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "renderer/core/error.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/image_check.h"
#include "tests/renderer/io/temporary_folder.h"

namespace pathfit::renderer::image_file_test {
namespace {

using std::string_literals::operator""s;

/// Smooth, and different in every channel and corner; values are multiples of 1/255.
Image MakeImage(int width, int height, int channels) {
  Image image(width, height, channels);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < channels; ++c) {
        image.At(x, y, c) = static_cast<float>((30 * c + 3 * x + 2 * y) % 256) / 255.0F;
      }
    }
  }
  return image;
}

std::string BytesOf(const std::vector<unsigned char>& bytes) {
  return {bytes.begin(), bytes.end()};
}

/// A JPEG file with an EXIF segment that holds only the orientation.
std::string JpegWithOrientation(const Image& image, int orientation, bool big_endian) {
  const std::string jpeg = BytesOf(EncodeJpeg(image, 100));
  const char value = static_cast<char>(orientation);
  const std::string tiff =
      big_endian ? "MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0"s + value + "\0\0\0\0\0\0"s
                 : "II\x2a\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0"s + value + "\0\0\0\0\0\0\0"s;
  const std::string payload = "Exif\0\0"s + tiff;
  const std::string segment = "\xff\xe1\0"s + static_cast<char>(payload.size() + 2) + payload;
  return jpeg.substr(0, 2) + segment + jpeg.substr(2);
}

TEST(ImageFile, PngRoundTripIsExact) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "a.png";
  const Image color = MakeImage(20, 13, 3);
  WritePng8(path, color);
  const DecodedImage decoded = ReadImageFile(path, false);
  EXPECT_EQ(decoded.image.data, color.data);
  EXPECT_EQ(decoded.image.width, 20);
  EXPECT_TRUE(decoded.alpha.Empty());
  EXPECT_FALSE(decoded.linear);
  EXPECT_EQ(decoded.bits, 8);
  EXPECT_EQ(decoded.exif_orientation, 1);
  const Image gray = MakeImage(20, 13, 1);
  WritePng8(path, gray);
  const Image repeated = ReadImageFile(path, false).image;
  ASSERT_EQ(repeated.channels, 3);
  for (std::size_t i = 0; i < repeated.data.size(); ++i) {
    EXPECT_EQ(repeated.data[i], gray.data[i / 3]);
  }
}

TEST(ImageFile, EncodersClampAndRefuse) {
  const TemporaryFolder folder;
  Image image(2, 1, 1);
  image.data = {-3.0F, 7.0F};
  WritePng8(folder.Path() / "a.png", image);
  const Image clamped = ReadImageFile(folder.Path() / "a.png", false).image;
  EXPECT_EQ(clamped.At(0, 0, 0), 0.0F);
  EXPECT_EQ(clamped.At(1, 0, 2), 1.0F);
  image.data[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(EncodePng(image), NumericalError);
  EXPECT_THROW(EncodeJpeg(Image(), 90), IoError);
  EXPECT_THROW(EncodePng(Image(3, 3, 2)), IoError);
  EXPECT_THROW(WritePng8(folder.Path() / "no" / "a.png", MakeImage(2, 2, 3)), IoError);
}

TEST(ImageFile, JpegStaysCloseAndInRgbOrder) {
  const TemporaryFolder folder;
  const Image color = MakeImage(32, 24, 3);
  const Image decoded =
      ReadImageFile(folder.Write("a.jpg", BytesOf(EncodeJpeg(color, 100))), false).image;
  ASSERT_EQ(decoded.data.size(), color.data.size());
  for (std::size_t i = 0; i < color.data.size(); ++i) {
    EXPECT_NEAR(decoded.data[i], color.data[i], 0.03F);
  }
}

TEST(ImageFile, ReadsAlphaAndSixteenBitsFromPngAndTiff) {
  const TemporaryFolder folder;
  cv::Mat pixels(3, 5, CV_16UC4);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 5; ++x) {
      pixels.at<cv::Vec<std::uint16_t, 4>>(y, x) = {
          1, static_cast<std::uint16_t>(1000 * x), 65535, static_cast<std::uint16_t>(y * 20000)};
    }
  }
  for (const char* extension : {".png", ".tiff"}) {
    std::vector<unsigned char> bytes;
    ASSERT_TRUE(cv::imencode(extension, pixels, bytes));
    const DecodedImage decoded =
        ReadImageFile(folder.Write(std::string("a") + extension, BytesOf(bytes)), false);
    EXPECT_EQ(decoded.bits, 16);
    EXPECT_FALSE(decoded.linear);
    EXPECT_EQ(decoded.image.At(3, 1, 0), 1.0F);
    EXPECT_EQ(decoded.image.At(3, 1, 1), 3000.0F / 65535.0F);
    EXPECT_EQ(decoded.image.At(3, 1, 2), 1.0F / 65535.0F);
    ASSERT_FALSE(decoded.alpha.Empty());
    EXPECT_EQ(decoded.alpha.At(2, 2, 0), 40000.0F / 65535.0F);
  }
}

TEST(ImageFile, FloatFormatsAreLinear) {
  const TemporaryFolder folder;
  Image image(9, 2, 3);
  for (float& value : image.data) value = 2.5F;
  WriteExr(folder.Path() / "a.exr", image);
  WriteHdr(folder.Path() / "a.hdr", image);
  std::vector<unsigned char> tiff;
  ASSERT_TRUE(cv::imencode(".tiff", cv::Mat(2, 9, CV_32FC3, cv::Scalar(2.5, 2.5, 2.5)), tiff));
  folder.Write("a.tif", BytesOf(tiff));
  for (const char* name : {"a.exr", "a.hdr", "a.tif"}) {
    const DecodedImage decoded = ReadImageFile(folder.Path() / name, true);
    EXPECT_TRUE(decoded.linear) << name;
    EXPECT_EQ(decoded.bits, 32) << name;
    EXPECT_EQ(decoded.image.channels, 3) << name;
    // OpenCV writes float TIFF with a logarithmic coding of 16 bits.
    EXPECT_NEAR(decoded.image.At(8, 1, 2), 2.5F, 0.05F) << name;
  }
}

TEST(ImageFile, OrientationIsReportedAndAppliedOnRequest) {
  const TemporaryFolder folder;
  Image image(32, 16, 3);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) image.At(x, y, 0) = 1.0F;  // marks the stored top left corner
  }
  // Where that corner is shown: x and y from the left and top (0) or right and bottom (1).
  const int shown[8][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const std::filesystem::path path =
        folder.Write("a.jpg", JpegWithOrientation(image, orientation, orientation % 2 == 0));
    const DecodedImage stored = ReadImageFile(path, false);
    EXPECT_EQ(stored.exif_orientation, orientation);
    EXPECT_EQ(stored.image.width, 32);
    EXPECT_GT(stored.image.At(1, 1, 0), 0.9F);
    const Image upright = ReadImageFile(path, true).image;
    EXPECT_EQ(upright.width, orientation >= 5 ? 16 : 32);
    const int x = shown[orientation - 1][0] == 0 ? 1 : upright.width - 2;
    const int y = shown[orientation - 1][1] == 0 ? 1 : upright.height - 2;
    EXPECT_GT(upright.At(x, y, 0), 0.9F) << orientation;
  }
}

TEST(ImageFile, ApplyOrientationTurnsAsTheStandardSays) {
  Image image(3, 2, 1);
  image.data = {1, 2, 3, 4, 5, 6};
  EXPECT_EQ(ApplyOrientation(image, 6).data, (std::vector<float>{4, 1, 5, 2, 6, 3}));
  EXPECT_EQ(ApplyOrientation(image, 8).data, (std::vector<float>{3, 6, 2, 5, 1, 4}));
  EXPECT_EQ(ApplyOrientation(image, 3).data, (std::vector<float>{6, 5, 4, 3, 2, 1}));
  EXPECT_EQ(ApplyOrientation(image, 5).data, (std::vector<float>{1, 4, 2, 5, 3, 6}));
}

int OrientationIn(const std::string& jpeg) { return OrientationOfExif(ExifOfJpeg(jpeg)); }

TEST(ImageFile, MalformedOrientationCountsAsNone) {
  const Image image = MakeImage(8, 8, 3);
  EXPECT_EQ(OrientationIn(JpegWithOrientation(image, 9, false)), 1);
  EXPECT_EQ(OrientationIn(JpegWithOrientation(image, 0, true)), 1);
  EXPECT_EQ(OrientationIn("\xff\xd8\xff\xe1"s), 1);
  EXPECT_EQ(OrientationIn(""), 1);
  std::string bytes = JpegWithOrientation(image, 6, false);
  EXPECT_EQ(OrientationIn(bytes), 6);
  for (std::size_t size = 0; size < 40; ++size) {
    const int orientation = OrientationIn(bytes.substr(0, size));
    EXPECT_TRUE(orientation == 1 || orientation == 6);
  }
  // A directory far beyond the end.
  bytes.replace(bytes.find("II") + 4, 4, "\xff\xff\xff\xff");
  EXPECT_EQ(OrientationIn(bytes), 1);
}

TEST(ImageFile, RefusesOtherFilesAndHostileSizes) {
  const TemporaryFolder folder;
  EXPECT_NE(IoErrorOf([&] {
              ReadImageFile(folder.Write("a.jpg", "GIF89a"), false);
            }).find("allowed are JPEG, PNG, TIFF, HDR and EXR"),
            std::string::npos);
  EXPECT_THROW(ReadImageFile(folder.Write("b.jpg", ""), false), IoError);
  EXPECT_THROW(ReadImageFile(folder.Path() / "none.png", false), IoError);
  // The largest size that is read, which files of this size cannot hold.
  const auto claim = [](const std::string& bytes, std::size_t at, const std::string& size) {
    const TemporaryFolder own;
    return IoErrorOf([&] {
      ReadImageFile(own.Write("claim", std::string(bytes).replace(at, size.size(), size)), false);
    });
  };
  std::string png = BytesOf(EncodePng(MakeImage(4, 4, 3)));
  const std::string jpeg = BytesOf(EncodeJpeg(MakeImage(4, 4, 3), 90));
  const std::string claimed = "claims 16384 x 16384 pixels (3222 MB in memory)";
  const std::string of_png = claim(png, 16, "\0\0\x40\0\0\0\x40\0"s);
  EXPECT_NE(of_png.find(claimed), std::string::npos) << of_png;
  EXPECT_NE(of_png.find("no file of " + std::to_string(png.size()) + " bytes"), std::string::npos);
  EXPECT_NE(of_png.find("claim: "), std::string::npos);
  const std::string of_jpeg = claim(jpeg, jpeg.find("\xff\xc0") + 5, "\x40\0\x40\0"s);
  EXPECT_NE(of_jpeg.find(claimed), std::string::npos) << of_jpeg;
  const std::string of_inks = claim(jpeg, jpeg.find("\xff\xc0") + 9, "\4");
  EXPECT_NE(of_inks.find("is of four inks (CMYK); store it as RGB"), std::string::npos) << of_inks;
  std::vector<unsigned char> tiff;
  ASSERT_TRUE(cv::imencode(".tiff", cv::Mat::zeros(4, 4, CV_8UC3), tiff));
  std::string tiff_bytes = BytesOf(tiff);
  for (const char tag : {'\0', '\1'}) {  // width and height, SHORT
    const std::size_t at = tiff_bytes.find(std::string(1, tag) + "\1\3\0\1\0\0\0"s);
    ASSERT_NE(at, std::string::npos);
    tiff_bytes.replace(at + 8, 2, "\0\x40"s);
  }
  const std::string of_tiff = claim(tiff_bytes, 0, "");
  EXPECT_NE(of_tiff.find(claimed), std::string::npos) << of_tiff;
  // What compresses best is read.
  const TemporaryFolder large;
  cv::Mat black = cv::Mat::zeros(1024, 4096, CV_8U);
  ASSERT_TRUE(cv::imwrite((large.Path() / "b.png").string(),
                          black,
                          {cv::IMWRITE_PNG_BILEVEL, 1, cv::IMWRITE_PNG_COMPRESSION, 9}));
  ASSERT_TRUE(cv::imwrite((large.Path() / "b.jpg").string(),
                          black,
                          {cv::IMWRITE_JPEG_PROGRESSIVE, 1, cv::IMWRITE_JPEG_OPTIMIZE, 1}));
  WriteExr(large.Path() / "b.exr", Image(4096, 1024, 1));
  WriteHdr(large.Path() / "b.hdr", Image(4096, 64, 3));
  for (const char* name : {"b.png", "b.jpg", "b.exr", "b.hdr"}) {
    EXPECT_EQ(ReadImageFile(large.Path() / name, false).image.width, 4096) << name;
  }
  png.replace(16, 8, "\x7f\xff\xff\xff\x7f\xff\xff\xff");
  EXPECT_NE(
      IoErrorOf([&] { ReadImageFile(folder.Write("c.png", png), false); }).find("is not allowed"),
      std::string::npos);
}

TEST(ImageFile, SurvivesCutAndDamagedFiles) {
  const TemporaryFolder folder;
  const auto read = [](const std::filesystem::path& file) { ReadImageFile(file, true); };
  const Image image = MakeImage(40, 30, 3);
  std::vector<unsigned char> tiff;
  cv::Mat pixels(30, 40, CV_16UC3);
  cv::randu(pixels, 0, 65535);
  ASSERT_TRUE(cv::imencode(".tiff", pixels, tiff));
  for (const std::filesystem::path& path :
       {folder.Write("a.png", BytesOf(EncodePng(image))),
        folder.Write("a.jpg", JpegWithOrientation(image, 6, true)),
        folder.Write("a.tiff", BytesOf(tiff))}) {
    ExpectCutFilesRefused(path, ReadWholeFile(path).size(), 150, read);
    ExpectDamagedFilesSurvived(path, 200, read);
  }
}

Image Read(const std::filesystem::path& path) { return ReadImageFile(path, false).image; }

Image MakeRadiance(int width, int height) {
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
    const Image image = MakeRadiance(width, 6);
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

/// What ReadImageFile says about a file of these bytes.
std::string HdrError(const std::string& bytes) {
  const TemporaryFolder folder;
  return IoErrorOf([&] { ReadImageFile(folder.Write("a.hdr", bytes), false); });
}

TEST(RadianceFile, DividesByExposure) {
  const TemporaryFolder folder;
  const Image image = Read(
      folder.Write("a.hdr",
                   "#?RADIANCE\nEXPOSURE=4\nFORMAT=32-bit_rle_rgbe\nEXPOSURE= 0.5\n\n-Y 1 +X 2\n"
                   "\x80\x00\x00\x81\x00\x80\x00\x81"s));  // red 1, then green 1
  EXPECT_EQ(image.data, (std::vector<float>{0.5F, 0.0F, 0.0F, 0.0F, 0.5F, 0.0F}));
}

TEST(RadianceFile, RefusesMalformedFiles) {
  const std::string header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
  const std::string pixels(64, '\x01');
  const std::pair<std::string, std::string> cases[] = {
      {"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n" + pixels, "no line FORMAT="},
      {"#?RADIANCE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 1 +X 1\r\n" + pixels, "carriage return"},
      {header + "-Y 1 +X 1\r" + pixels, "carriage return"},
      {"#?RADIANCE\n" + std::string(127, 'c') + "\n" + header, "longer than 126 bytes"},
      {header + "-Y 1 +X 1" + std::string(127, ' ') + "\n" + pixels, "longer than 126 bytes"},
      {"#?RADIANCE\n\0\n"s + header, "begins with a zero byte"},
      {"#?RADIANCE\nEXPOSURE=-1\n\n", "EXPOSURE must be positive"},
      {"#?RADIANCE\n", "has no end"},
      {header, "the size is missing"},
      {header + "-Y 2\n", "the size must look like"},
      {header + "-Y 2 +Y 2\n", "the size must look like"},
      {header + "+Y 2 +X 2\n" + pixels, "turned or mirrored"},
      {header + "-Y 0 +X 2\n", "image size 2 x 0"},
      {header + "-Y 900000000 +X 900000000\n", "is not allowed"},
      {header + "-Y 10000 +X 10000\n\x02\x02", "claims 10000 x 10000 pixels (1200 MB in memory)"},
      {header + "-Y 1 +X 8\n\x02\x02\x00\x09"s + pixels, "another width"},
      {header + "-Y 1 +X 8\n\x02\x02\x00\x08"s + std::string(40, '\xff'), "does not fit"},
      {header + "-Y 1 +X 8\n\x02\x02\x00\x08"s + std::string(40, '\0'), "does not fit"},
      {header + "-Y 1 +X 4\n\x80\x40\x20\x81\x01\x01\x01\x03", "before 1991"},
      // As many bytes as two rows of plain pixels.
      {header + "-Y 2 +X 8\n\x80\x40\x20\x81\x01\x01\x01\x07" + std::string(64, '\x80'),
       "before 1991"},
      // After a row of new runs: four times eight black.
      {header + "-Y 2 +X 8\n\2\2\0\10\x88\0\x88\0\x88\0\x88\0"s +
           "\x80\x40\x20\x81\x01\x01\x01\x07" + std::string(64, '\x80'),
       "before 1991"},
  };
  for (const auto& [bytes, message] : cases) {
    const std::string got = HdrError(bytes);
    EXPECT_NE(got.find(message), std::string::npos) << got << "\nwanted " << message;
  }
}

// A decoder that gives up must give back its file.
TEST(RadianceFile, RefusedFilesStayClosed) {
  const auto open_files = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"),
                         std::filesystem::directory_iterator());
  };
  const auto before = open_files();
  for (int i = 0; i < 20; ++i) {
    HdrError("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n\x02\x02\x00\x09" +
             std::string(64, '\x01'));
  }
  EXPECT_EQ(open_files(), before);
}

TEST(RadianceFile, RefusesToWriteWhatItCannotHold) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.Path() / "a.hdr";
  Image image = MakeRadiance(3, 3);
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
    WriteHdr(path, MakeRadiance(width, 5));
    ExpectCutFilesRefused(path, ReadWholeFile(path).size(), 150, Read);
    ExpectDamagedFilesSurvived(path, 200, Read);
  }
}

}  // namespace
}  // namespace pathfit::renderer::image_file_test
