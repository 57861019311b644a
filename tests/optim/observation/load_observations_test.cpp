#include "optim/observation/load_observations.h"

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "optim/observation/observation_stream.h"
#include "optim/observation/photo_file.h"
#include "renderer/image/color.h"
#include "renderer/io/image_file.h"
#include "renderer/io/raw_file.h"
#include "tests/optim/observation/exif_bytes.h"
#include "tests/optim/observation/observation_files.h"
#include "tests/renderer/io/dng_bytes.h"
#include "tests/renderer/io/icc_bytes.h"

namespace pathfit::optim::load_observations_test {
namespace {

namespace fs = std::filesystem;
using renderer::Image;

constexpr const char* kMatrix = "[[0,-1,0,-2],[0,0,-1,-3],[1,0,0,-1],[0,0,0,1]]";

// An 8x4 grey JPEG (value 128) with EXIF orientation 6: viewers show it as 4x8.
constexpr const char* kTurnedJpeg =
    "ffd8ffe100224578696600004d4d002a00000008000101120003000000010006000000000000ffe000104a46"
    "494600010100000100010000ffdb0043000302020302020303030304030304050805050404050a070706080c"
    "0a0c0c0b0a0b0b0d0e12100d0e110e0b0b1016101113141515150c0f171816141812141514ffc0000b080004"
    "000801011100ffc40014000100000000000000000000000000000000ffc40014100100000000000000000000"
    "000000000000ffda0008010100003f003fffd9";

// White 8x4 PNG files with an alpha channel: opaque, and transparent in column 5 of row 2.
constexpr const char* kOpaquePng =
    "89504e470d0a1a0a0000000d4948445200000008000000040806000000b3cd7ef0000000144944415408d763"
    "fc0f040c780013030140b9020006ac0404b496453a0000000049454e44ae426082";

constexpr const char* kHolePng =
    "89504e470d0a1a0a0000000d4948445200000008000000040806000000b3cd7ef0000000194944415408d763"
    "fc0f040c7800130301804b01232105706b010fcd050444ee1cfd0000000049454e44ae426082";

std::string BytesFromHex(const std::string& hex) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

class LoadObservationsTest : public ::testing::Test {
 protected:
  /// A camera file with a frame of these keys for each photo.
  void WriteCameras(const std::vector<std::string>& names,
                    const std::string& extra = "",
                    int width = 8,
                    int height = 4) {
    std::string text = "{\"fl_x\": 10, \"w\": " + std::to_string(width) +
                       ", \"h\": " + std::to_string(height) + ", \"frames\": [";
    for (std::size_t i = 0; i < names.size(); ++i) {
      text += std::string(i == 0 ? "" : ",") + "{\"file_path\": \"" + names[i] + "\", " + extra +
              "\"transform_matrix\": " + kMatrix + "}";
    }
    options_.cameras = folder_.WriteText("transforms.json", text + "]}");
  }
  fs::path Write(const std::string& name, const Image& image) const {
    fs::path path = folder_.WriteText(name, "");
    renderer::WritePng8(path, image);
    return path;
  }
  void WritePhoto(const std::string& name,
                  int width = 8,
                  int height = 4,
                  float value = 0.5F) const {
    Write(name, ConstantImage(width, height, 3, value));
  }
  [[nodiscard]] std::vector<std::string> Problems() const {
    try {
      LoadObservations(options_);
    } catch (const ObservationError& error) {
      return error.Problems();
    }
    return {};
  }
  void ExpectOneProblem(const std::vector<std::string>& parts) const {
    const std::vector<std::string> problems = Problems();
    ASSERT_EQ(problems.size(), 1U);
    for (const std::string& part : parts) {
      EXPECT_NE(problems[0].find(part), std::string::npos)
          << "'" << part << "' is not in: " << problems[0];
    }
  }
  static std::string All(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) {
      text += line + "\n";
    }
    return text;
  }
  void ExpectAssumption(const std::string& part) const {
    const std::string text = All(LoadObservations(options_).assumptions);
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in: " << text;
  }

  LoadObservationsTest() { options_.validation_every = 0; }

  TempFolder folder_;
  ObservationOptions options_;
};

TEST_F(LoadObservationsTest, KnownPointLandsOnTheSamePlaceAtHalfSize) {
  options_.cameras = folder_.WriteText(
      "transforms.json",
      std::string(
          "{\"fl_x\": 200, \"fl_y\": 400, \"cx\": 100.5, \"cy\": 60.25, \"w\": 200, \"h\": 120, "
          "\"k1\": 0.128, \"k2\": 1.6384, \"p1\": 0.16, \"p2\": 0.32, "
          "\"frames\": [{\"file_path\": \"a.png\", \"transform_matrix\": ") +
          kMatrix + "}]}");
  const double u = 166.5;  // by hand, see camera_import_test
  const double v = 126.25 - 60.0;
  Image photo = ConstantImage(200, 120, 3, 0.0F);
  for (int y = 66; y < 68; ++y) {
    for (int x = 166; x < 168; ++x) {
      photo.At(x, y, 0) = photo.At(x, y, 1) = photo.At(x, y, 2) = 1.0F;
    }
  }
  Write("a.png", photo);
  options_.max_size_px = 100;
  ObservationSet set = LoadObservations(options_);
  ASSERT_EQ(set.views.size(), 1U);
  EXPECT_EQ(set.views[0].photo.width(), 100);
  EXPECT_EQ(set.views[0].photo.height(), 60);
  EXPECT_EQ(set.views[0].file_width, 200);
  EXPECT_EQ(set.views[0].file_height, 120);
  set.views[0].camera.cy -= 30.0;  // brings the point into the picture, for the pixel below
  const std::optional<renderer::Projection> p =
      renderer::CameraModel(set.views[0].camera).Project({-1.75, -1.0, -0.5});
  ASSERT_TRUE(p.has_value());
  EXPECT_NEAR(p->u, 0.5 * u, 1e-9);
  EXPECT_NEAR(p->v, 0.5 * v, 1e-9);
  EXPECT_NEAR(set.views[0].photo.Unpack().At(static_cast<int>(p->u), static_cast<int>(p->v), 0),
              1.0F,
              1e-6F);
  EXPECT_NEAR(set.views[0].photo.Unpack().At(static_cast<int>(p->u) + 1, static_cast<int>(p->v), 0),
              0.0F,
              1e-6F);
}

TEST_F(LoadObservationsTest, EightBitsAreMadeLinearBeforeAveraging) {
  WriteCameras({"a.png"});
  Image photo = ConstantImage(8, 4, 3, 0.0F);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 8; x += 2) {
      photo.At(x, y, 1) = 128.0F / 255.0F;
    }
  }
  Write("a.png", photo);
  const double expected = renderer::LinearFromSrgb(128.0 / 255.0);
  EXPECT_NEAR(LoadObservations(options_).views[0].photo.Unpack().At(2, 1, 1), expected, 1e-6);
  EXPECT_EQ(LoadObservations(options_).views[0].photo.Unpack().At(2, 1, 0), 0.0F);
  options_.max_size_px = 4;
  EXPECT_NEAR(LoadObservations(options_).views[0].photo.Unpack().At(2, 1, 1), 0.5 * expected, 1e-6);
  options_.max_size_px = 0;
  options_.transfer = Transfer::kLinear;
  EXPECT_NEAR(LoadObservations(options_).views[0].photo.Unpack().At(2, 1, 1), 128.0 / 255.0, 1e-6);
}

TEST_F(LoadObservationsTest, ColorProfilesAreUndoneUnlessTheConfigSaysWhatPhotosAre) {
  Image red = ConstantImage(8, 4, 3, 0.0F);
  for (std::size_t i = 0; i < red.data.size(); i += 3) red.data[i] = 0.8F;
  folder_.WriteText("a.png", renderer::PngWith(renderer::RgbProfile(renderer::kP3), red));
  WriteCameras({"a.png"});
  const auto red_of = [&] {
    return static_cast<double>(LoadObservations(options_).views[0].photo.Unpack().data[0]);
  };
  const double linear = renderer::LinearFromSrgb(204.0 / 255.0);
  EXPECT_NEAR(red_of(), 1.22494 * linear, 1e-3);
  ExpectAssumption("from the colour profile 'RGB built-in'");
  options_.transfer = Transfer::kSrgb;
  EXPECT_NEAR(red_of(), linear, 1e-4);
  folder_.WriteText("a.png", renderer::PngWith("no profile", red));
  EXPECT_NEAR(red_of(), linear, 1e-4);
  options_.transfer = Transfer::kAuto;
  ExpectOneProblem({"a.png: its colour profile is damaged", "transfer 'srgb'"});
}

TEST_F(LoadObservationsTest, PhotosThatExifCallsAdobeRgbHaveItsCurve) {
  const std::vector<unsigned char> grey = renderer::EncodeJpeg(ConstantImage(8, 4, 3, 0.5F), 95);
  folder_.WriteText("a.jpg", WithExif(grey, ColorBlock('\xff', "R03")));
  WriteCameras({"a.jpg"});
  const auto value = [&] {
    return static_cast<double>(LoadObservations(options_).views[0].photo.Unpack().data[0]);
  };
  EXPECT_NEAR(value(), std::pow(128.0 / 255.0, 563.0 / 256.0), 1e-3);
  ExpectAssumption("from the colour profile 'Adobe RGB (1998)'");
  options_.transfer = Transfer::kSrgb;
  EXPECT_NEAR(value(), renderer::LinearFromSrgb(128.0 / 255.0), 1e-3);
}

TEST_F(LoadObservationsTest, GreyPhotosAreSaidToBeGrey) {
  WriteCameras({"a.png", "b.png"});
  Write("a.png", ConstantImage(8, 4, 1, 0.5F));
  Write("b.png", ConstantImage(8, 4, 1, 0.5F));
  LoadObservations(options_);
  ExpectAssumption("2 photos with one channel, grey: red, green and blue are taken to be alike.");
  Write("b.png", ConstantImage(8, 4, 3, 0.5F));
  LoadObservations(options_);
  ExpectAssumption(
      "1 photo with one channel, grey: red, green and blue are taken to be alike, "
      "which they are not in the others.");
}

TEST_F(LoadObservationsTest, ClippingIsCountedOnEncodedValues) {
  WriteCameras({"a.png"});
  Image photo = ConstantImage(8, 4, 3, 0.5F);
  photo.At(3, 1, 2) = 1.0F;
  photo.At(4, 1, 2) = 250.0F / 255.0F;  // 0.98, beside a clipped one
  photo.At(6, 3, 2) = 250.0F / 255.0F;
  Write("a.png", photo);
  const View view = LoadObservations(options_).views[0];
  ASSERT_FALSE(view.clipped.Empty());
  EXPECT_EQ(view.clipped.Unpack().At(3, 1, 0), 1.0F);
  EXPECT_EQ(view.clipped.Unpack().At(4, 1, 0), 1.0F);
  EXPECT_EQ(view.clipped.Unpack().At(2, 1, 0), 0.0F) << "dark";
  EXPECT_EQ(view.clipped.Unpack().At(6, 3, 0), 0.0F) << "alone";
  ExpectAssumption("6.25 % of all");
  options_.max_size_px = 4;
  EXPECT_NEAR(LoadObservations(options_).views[0].clipped.Unpack().At(1, 0, 0), 0.25F, 1e-6F);
  options_.clip_above = 1.0;
  EXPECT_TRUE(LoadObservations(options_).views[0].clipped.Empty());
}

TEST_F(LoadObservationsTest, ExifOrientationIsIgnoredUnlessAskedFor) {
  folder_.WriteText("turned.jpg", BytesFromHex(kTurnedJpeg));
  WriteCameras({"turned.jpg"});
  EXPECT_EQ(LoadObservations(options_).views[0].photo.width(), 8);
  ExpectAssumption("EXIF rotation, which was ignored");
  WriteCameras({"turned.jpg"}, "", 4, 8);
  ExpectOneProblem(
      {"turned.jpg", "8x4", "4x8", "swapped", "EXIF orientation 6", "'sensor'", "use 'exif'"});
  options_.apply_exif_orientation = true;
  EXPECT_EQ(LoadObservations(options_).views[0].photo.height(), 8);
  ExpectAssumption("applied");
  WriteCameras({"turned.jpg"});
  ExpectOneProblem({"swapped", "EXIF orientation 6", "'exif'", "use 'sensor'"});
}

TEST_F(LoadObservationsTest, ViewsAreSortedAndSplitFromTheFirst) {
  std::vector<std::string> names;
  for (const char* name : {"c.png", "a.png", "e.png", "b.png", "d.png"}) {
    names.emplace_back(std::string("photos/") + name);
    WritePhoto(names.back());
  }
  WriteCameras(names);
  options_.validation_every = 2;
  const ObservationSet set = LoadObservations(options_);
  ASSERT_EQ(set.views.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(set.views[i].name, std::string(1, static_cast<char>('a' + i)) + ".png");
    EXPECT_EQ(set.views[i].camera.name, set.views[i].name);
    EXPECT_EQ(set.views[i].validation, i % 2 == 0);
  }
  ExpectAssumption("2 fitted, 3 for validation");
  options_.validation_names = {"b.png"};
  EXPECT_TRUE(LoadObservations(options_).views[1].validation);
  EXPECT_FALSE(LoadObservations(options_).views[0].validation);
  options_.validation_names = {"z.png"};
  ExpectOneProblem({"validation", "z.png"});
}

TEST_F(LoadObservationsTest, RefusesASplitThatLeavesNothingToFit) {
  WritePhoto("a.png");
  WriteCameras({"a.png"});
  options_.validation_every = 8;
  ExpectOneProblem({"validation", "none is left to fit"});
}

TEST_F(LoadObservationsTest, CollectsAllProblems) {
  WritePhoto("b.png", 7, 4);
  folder_.WriteText("c.png", "not a picture");
  WriteCameras({"a.png", "b.png", "c.png", "c.png"});
  options_.max_size_px = -1;
  const std::vector<std::string> problems = Problems();
  const std::string text = All(problems);
  EXPECT_EQ(problems.size(), 6U)
      << text;  // both entries of c.png are unreadable, and it is given twice
  for (const char* part : {"frames[0]",
                           "a.png is missing (tried: ",
                           "b.png: 7x4 pixels",
                           "camera says 8x4",
                           "c.png",
                           "given twice",
                           "largest image size"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in: " << text;
  }
}

TEST_F(LoadObservationsTest, IntegerRescaleMovesTheCamera) {
  WritePhoto("a.png", 4, 2);
  WriteCameras({"a.png"});
  const View view = LoadObservations(options_).views[0];
  EXPECT_EQ(view.camera.width, 4);
  EXPECT_EQ(view.camera.fx, 5.0);
  EXPECT_EQ(view.camera.cx, 2.0);
  ExpectAssumption("another size than the 8x4");
  WriteCameras({"a.png"}, "", 9, 5);  // halves round down
  EXPECT_EQ(LoadObservations(options_).views[0].camera.width, 4);
  WriteCameras({"a.png"}, "", 8, 8);
  ExpectOneProblem({"4x2 pixels", "8x8", "whole number"});
  WriteCameras({"a.png"}, "", 6, 3);
  ExpectOneProblem({"4x2 pixels", "6x3"});
}

TEST_F(LoadObservationsTest, DistortionCanBeRefused) {
  WritePhoto("a.png");
  WriteCameras({"a.png"}, "\"k1\": 0.05, ");
  EXPECT_EQ(LoadObservations(options_).views[0].camera.distortion.k1, 0.05);
  ExpectAssumption("1 camera with distortion");
  options_.distortion = DistortionPolicy::kRefuse;
  ExpectOneProblem({"frames[0]", "k1 = 0.05", "'refuse'", "'model'"});
}

TEST_F(LoadObservationsTest, LensThatFoldsIsAProblem) {
  WritePhoto("a.png");
  WriteCameras({"a.png"}, "\"k1\": -9, ");
  ExpectOneProblem({"frames[0]", "folds"});
}

TEST_F(LoadObservationsTest, FindsMasksByEveryName) {
  options_.masks.meaning = MaskMeaning::kSilhouette;
  options_.masks.folder = folder_.path() / "masks";
  WritePhoto("a.jpg.png");  // its own name is no mask
  WriteCameras({"p/a.png"});
  WritePhoto("p/a.png");
  for (const char* name : {"masks/a.png.png", "masks/a.png", "masks/a.mask.png", "masks/p/a.png"}) {
    Image mask = ConstantImage(8, 4, 1, 0.0F);
    mask.At(2, 1, 0) = 1.0F;
    const fs::path path = Write(name, mask);
    const ObservationSet set = LoadObservations(options_);
    EXPECT_EQ(set.views[0].mask.Unpack().At(2, 1, 0), 1.0F) << name;
    EXPECT_EQ(set.views[0].mask.Unpack().At(3, 1, 0), 0.0F) << name;
    ExpectAssumption("1 of 1 matched (1 from " + options_.masks.folder.string() +
                     "); black means the object");
    fs::remove(path);
  }
}

TEST_F(LoadObservationsTest, PhotosOfTwoFoldersWithTheSameNamesAreNotMixedUp) {
  WriteCameras({"images/left/a.png", "images/right/a.png"});
  WritePhoto("images/left/a.png");
  WritePhoto("images/right/a.png");
  for (const char* side : {"left", "right"}) {
    Write(std::string("masks/") + side + "/a.png.png",
          ConstantImage(8, 4, 1, side == std::string("left") ? 1.0F : 0.0F));
  }
  options_.masks.meaning = MaskMeaning::kSilhouette;
  options_.masks.folder = folder_.path() / "masks";
  const ObservationSet set = LoadObservations(options_);
  EXPECT_EQ(set.views[0].mask.Unpack().At(0, 0, 0), 1.0F);
  EXPECT_EQ(set.views[1].mask.Unpack().At(0, 0, 0), 0.0F);
  options_.images_dir = folder_.path() / "images/left";
  ExpectOneProblem({"frames[1]", "images/right/a.png is missing", "images/left/a.png"});
}

TEST_F(LoadObservationsTest, MissingMasksAreProblemsUnlessAllowed) {
  options_.masks.meaning = MaskMeaning::kIgnore;
  options_.masks.folder = folder_.path() / "masks";
  WriteCameras({"a.png", "b.png"});
  WritePhoto("a.png");
  WritePhoto("b.png");
  WritePhoto("masks/b.png", 8, 4, 1.0F);
  ExpectOneProblem(
      {"a.png: has no mask", "tried", "masks/a.png.png", "masks/a.png", "masks/a.mask.png"});
  options_.masks.require = MaskRequirement::kSome;
  const ObservationSet set = LoadObservations(options_);
  EXPECT_TRUE(set.views[0].mask.Empty());
  EXPECT_FALSE(set.views[1].mask.Empty());
  fs::remove(folder_.path() / "masks/b.png");
  ExpectOneProblem({"masks: none", "at least one"});
  options_.masks.require = MaskRequirement::kNone;
  EXPECT_TRUE(LoadObservations(options_).views[1].mask.Empty());
  ExpectAssumption("0 of 2 matched");
}

TEST_F(LoadObservationsTest, AMaskFolderThatIsNotThereIsOneProblem) {
  WriteCameras({"a.png", "b.png"});
  WritePhoto("a.png");
  WritePhoto("b.png");
  options_.masks.meaning = MaskMeaning::kSilhouette;
  options_.masks.folder = folder_.path() / "msks";
  ExpectOneProblem({"masks: there is no folder (or file)", "msks"});
}

TEST_F(LoadObservationsTest, MaskPathOfTheCameraFileIsUsed) {
  options_.masks.meaning = MaskMeaning::kSilhouette;
  WriteCameras({"a.png"}, "\"mask_path\": \"m/x.png\", ");
  WritePhoto("a.png");
  ExpectOneProblem({"a.png: has no mask", "m/x.png"});
  WritePhoto("m/x.png", 8, 4, 1.0F);
  EXPECT_EQ(LoadObservations(options_).views[0].mask.Unpack().At(0, 0, 0), 1.0F);
  ExpectAssumption("1 by mask_path");
  options_.masks.invert = true;
  EXPECT_EQ(LoadObservations(options_).views[0].mask.Unpack().At(0, 0, 0), 0.0F);
  ExpectAssumption("show nothing at all: a.png");
  WritePhoto("m/x.png", 4, 2, 1.0F);
  ExpectOneProblem({"m/x.png: 4x2 pixels", "its photo", "8x4"});
}

TEST_F(LoadObservationsTest, AlphaIsAMaskOnlyIfItSaysSomething) {
  options_.masks.meaning = MaskMeaning::kSilhouette;
  WriteCameras({"a.png"});
  folder_.WriteText("a.png", BytesFromHex(kOpaquePng));
  ExpectOneProblem({"a.png: has no mask", "mask_path", "alpha channel with transparent pixels"});
  folder_.WriteText("a.png", BytesFromHex(kHolePng));
  EXPECT_EQ(LoadObservations(options_).views[0].mask.Unpack().At(5, 2, 0), 0.0F);
  EXPECT_EQ(LoadObservations(options_).views[0].mask.Unpack().At(4, 2, 0), 1.0F);
  ExpectAssumption("1 from alpha channels");
  WritePhoto("a.png");
  options_.masks.alpha = true;
  ExpectOneProblem({"no alpha channel"});
}

TEST_F(LoadObservationsTest, OtherProcessesReadTheSameImagesWhenTheyNeedThem) {
  WriteCameras({"a.png", "b.png", "c.png"}, "", 16, 8);
  Image photo = ConstantImage(16, 8, 3, 0.3F);
  photo.At(3, 5, 1) = 1.0F;
  photo.At(9, 2, 0) = 0.7F;
  Write("a.png", photo);
  folder_.WriteText("c.png", BytesFromHex(kHolePng));
  WritePhoto("b.png", 16, 8);
  Image mask = ConstantImage(16, 8, 3, 1.0F);
  mask.At(4, 4, 0) = 0.0F;
  Write("masks/a.png", mask);
  Write("masks/b.png", mask);
  Write("masks/c.png", ConstantImage(8, 4, 3, 0.25F));
  options_.masks.meaning = MaskMeaning::kSilhouette;
  options_.masks.folder = folder_.path() / "masks";
  options_.masks.invert = true;
  options_.masks.erode_px = 1;
  options_.max_size_px = 8;
  options_.validation_every = 3;
  const auto expect_same = [&] {
    const ObservationSet first = LoadObservations(options_);
    const ObservationSet other = DecodeObservations(EncodeObservations(first), options_);
    ASSERT_EQ(other.views.size(), first.views.size());
    EXPECT_EQ(other.mask_meaning, first.mask_meaning);
    EXPECT_EQ(other.assumptions, first.assumptions);
    for (std::size_t i = 0; i < first.views.size(); ++i) {
      const View& a = first.views[i];
      const View& b = other.views[i];
      EXPECT_EQ(a.name, b.name);
      EXPECT_EQ(a.validation, b.validation);
      EXPECT_EQ(a.camera.fx, b.camera.fx);
      EXPECT_EQ(a.mask.Empty(), b.mask.Empty());
      EXPECT_EQ(a.clipped.Empty(), b.clipped.Empty());
      const double scale = i == 1 ? 0.25 : 1.0;
      const PackedLevel level(b, other, scale);
      EXPECT_FALSE(b.photo.IsRead());
      EXPECT_EQ(b.photo.MemoryBytes() + b.mask.MemoryBytes() + level.MemoryBytes(), 0U);
      const ViewLevel expected = PackedLevel(a, first, scale).Unpack();
      const ViewLevel found = level.Unpack();
      EXPECT_EQ(found.photo.data, expected.photo.data) << a.name;
      EXPECT_EQ(found.mask.data, expected.mask.data) << a.name;
      EXPECT_EQ(found.clipped.data, expected.clipped.data) << a.name;
      EXPECT_EQ(found.color_weight.data, expected.color_weight.data) << a.name;
      EXPECT_TRUE(b.photo.IsRead());
      EXPECT_EQ(b.photo.Unpack().data, a.photo.Unpack().data);
      EXPECT_EQ(b.photo.MemoryBytes(), a.photo.MemoryBytes());
    }
  };
  expect_same();
  options_.masks.folder.clear();
  options_.masks.require = MaskRequirement::kSome;
  expect_same();  // by the alpha channel of one

  const ObservationSet first = LoadObservations(options_);
  const ObservationSet other = DecodeObservations(EncodeObservations(first), options_);
  fs::remove(folder_.path() / "a.png");
  WritePhoto("b.png", 4, 8);
  EXPECT_THROW((void)other.views[0].photo.Unpack(), renderer::IoError);
  EXPECT_THROW((void)other.views[1].photo.Unpack(), renderer::IoError);
}

TEST_F(LoadObservationsTest, ColmapModelFindsItsImagesFolder) {
  folder_.WriteText("ws/sparse/0/cameras.txt", "1 SIMPLE_PINHOLE 8 4 10 4 2\n");
  folder_.WriteText("ws/sparse/0/images.txt", "1 1 0 0 0 0 0 0 1 sub/a.png\n\n");
  WritePhoto("ws/images/sub/a.png");
  options_.cameras = folder_.path() / "ws";
  std::vector<InputFile> files;
  EXPECT_EQ(LoadObservations(options_, &files).views[0].name, "a.png");
  ASSERT_EQ(files.size(), 3U);
  EXPECT_EQ(files[2].path, folder_.path() / "ws/images/sub/a.png");
  // A model's own photos have its size; reduced copies are in a folder of their own.
  WritePhoto("ws/images/sub/a.png", 4, 2);
  ExpectOneProblem({"images/sub/a.png: 4x2 pixels", "8x4", "their folder is named"});
  options_.images_dir = folder_.path() / "ws/images";
  EXPECT_EQ(LoadObservations(options_).views[0].camera.fx, 5.0);
  options_.images_dir = folder_.path() / "elsewhere";
  ExpectOneProblem(
      {"images.txt:1", "sub/a.png is missing", "elsewhere/sub/a.png", "elsewhere/a.png"});
}

TEST_F(LoadObservationsTest, NerfNamesHaveNoExtension) {
  WriteCameras({"./train/r_0"});
  WritePhoto("train/r_0.png");
  EXPECT_EQ(LoadObservations(options_).views[0].name, "r_0");
}

class RawPhotos : public LoadObservationsTest {
 protected:
  void SetUp() override {
    if (renderer::LibRawVersion().empty()) GTEST_SKIP() << "built without LibRaw";
  }
  void WriteRaw(const std::string& name, double share = 0.25) const {
    folder_.WriteText(name, renderer::GreyDng(dng_, share));
  }
  renderer::DngCamera dng_;
};

TEST_F(RawPhotos, AreLinearWithWhiteBalanceClippingAndExposure) {
  WriteCameras({"a.dng", "b.dng"}, "", dng_.width, dng_.height);
  WriteRaw("a.dng", 0.25);
  dng_.time_s = {1, 30};
  dng_.as_shot_neutral = {0.5, 1.0, 0.5};
  WriteRaw("b.dng", 1.0);
  const ObservationSet set = LoadObservations(options_);
  EXPECT_EQ(set.views[0].name, "a.dng");
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(set.views[0].photo.Unpack().At(20, 10, c), 0.25F, 3e-4F);
    EXPECT_NEAR(set.views[1].photo.Unpack().At(20, 10, c), 1.0F, 1e-3F);
  }
  EXPECT_TRUE(set.views[0].clipped.Empty());
  EXPECT_EQ(set.views[1].clipped.Unpack().At(20, 10, 0), 1.0F);
  EXPECT_NEAR(set.views[1].exif_ev - set.views[0].exif_ev, 1.0F, 1e-5F);
  ExpectAssumption("Colour: 2 RAW photos developed to linear Rec.709 (LibRaw " +
                   renderer::LibRawVersion() +
                   "), white balance as the camera noted: red times 2, green 1, blue times 1.6 to "
                   "2. The photos differ:");
  ExpectAssumption(
      "0.99 of the encoded range (RAW: of the sensor's) count as clipped, and those beside them "
      "that "
      "nearly are; that is 50 %");
  options_.white_balance = renderer::RawWhiteBalance::kNone;
  ExpectAssumption("no white balance: red times 1, green 1, blue times 1.");
  options_.max_size_px = dng_.width / 2;
  EXPECT_EQ(LoadObservations(options_).views[0].photo.width(), dng_.width / 2);
}

TEST_F(RawPhotos, StandInForTheJpegsOfTheCameraFile) {
  WriteCameras({"photos/IMG_1.JPG", "photos/IMG_2"}, "", dng_.width, dng_.height);
  WriteRaw("photos/IMG_1.DNG");
  WriteRaw("photos/IMG_2.dng");
  EXPECT_EQ(LoadObservations(options_).views[0].files.photo.filename(), "IMG_1.DNG");
  // What the camera file names comes first.
  WritePhoto("photos/IMG_1.JPG", dng_.width, dng_.height);
  EXPECT_EQ(LoadObservations(options_).views[0].files.photo.filename(), "IMG_1.JPG");
  ExpectAssumption("Colour: 1 RAW photo developed");
  const std::vector<fs::path> pictures = PicturesIn(folder_.path() / "photos");
  ASSERT_EQ(pictures.size(), 3U);
  const std::vector<fs::path> each_once = WithoutRawTwins(pictures);
  ASSERT_EQ(each_once.size(), 2U);
  EXPECT_EQ(each_once[0].filename(), "IMG_1.JPG");
  EXPECT_EQ(each_once[1].filename(), "IMG_2.dng");
  // Another ending of a name is no extension.
  WriteCameras({"photos/IMG_2.0001"}, "", dng_.width, dng_.height);
  ExpectOneProblem({"photos/IMG_2.0001", "is missing"});
}

TEST_F(RawPhotos, ThatAreTurnedSaySo) {
  dng_.orientation = 6;
  WriteCameras({"a.dng"}, "", dng_.height, dng_.width);
  WriteRaw("a.dng");
  ExpectOneProblem({"a.dng", "48x32", "32x48", "swapped", "EXIF orientation 6", "use 'exif'"});
  options_.apply_exif_orientation = true;
  EXPECT_EQ(LoadObservations(options_).views[0].photo.width(), dng_.height);
  options_.apply_exif_orientation = false;
  WriteCameras({"a.dng"}, "", dng_.width, dng_.height);
  ExpectAssumption("Programs that read RAW photos often turn them. If the cameras were found on");
}

TEST_F(RawPhotos, ThatAreWrongAreRefusedTogether) {
  WriteCameras({"a.dng", "b.nef"}, "", dng_.width, dng_.height);
  WriteRaw("a.dng");
  folder_.WriteText("b.nef", "no photo");
  ExpectOneProblem({"b.nef: cannot be read as a RAW photo"});
  WriteCameras({"a.dng", "b.nef"}, "", dng_.width - 1, dng_.height);
  options_.transfer = Transfer::kSrgb;
  const std::vector<std::string> problems = Problems();
  ASSERT_EQ(problems.size(), 2U);
  EXPECT_NE(problems[0].find("RAW photos are linear"), std::string::npos);
  options_.transfer = Transfer::kAuto;
  WriteCameras({"a.dng"}, "", dng_.width - 1, dng_.height);
  ExpectOneProblem({"a.dng", "(RAW: all pixels"});
}

TEST(SetMetresPerUnit, TakesThePlaceOfWhatTheCameraFileSays) {
  ObservationSet set;
  set.metres_per_unit = 0.5;
  set.assumptions = {"Cameras: two.", "Scale: as the file says.", "More."};
  SetMetresPerUnit(0.25, "as I say", set);
  EXPECT_EQ(set.metres_per_unit, 0.25);
  ASSERT_EQ(set.assumptions.size(), 3U);
  EXPECT_EQ(set.assumptions[1],
            "Scale: 1 unit of the camera file is 0.25 m, as I say; the file says 0.5 m, which is "
            "not used; poses stay in units of the file.");
}

}  // namespace
}  // namespace pathfit::optim::load_observations_test
