#include "renderer/io/raw_file.h"

#include <cmath>
#include <cstdlib>
#include <utility>

#include <gtest/gtest.h>

#include "renderer/io/image_file.h"
#include "tests/renderer/io/dng_bytes.h"
#include "tests/renderer/io/temporary_folder.h"

namespace pathfit::renderer::raw_file_test {
namespace {

// Of the largest channel. The library cuts to whole numbers: to one in 3276 in the darkest patch,
// whose green is a tenth of half of 65535, and the matrix adds up channels with weights up to 2.
constexpr double kRounding = 1e-3;

class RawFile : public ::testing::Test {
 protected:
  void SetUp() override {
    if (LibRawVersion().empty()) GTEST_SKIP() << "built without LibRaw";
  }
  [[nodiscard]] RawPhoto Develop(const std::string& bytes, const RawOptions& options = {}) const {
    return ReadRawFile(folder_.Write("a.dng", bytes), options);
  }
  static void ExpectColor(const Rgb& color, const Rgb& expected) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(color[c], expected[c], kRounding * MaxChannel(expected)) << c;
    }
  }
  TemporaryFolder folder_;
  DngCamera camera_;
};

TEST_F(RawFile, GreyUnderTheCamerasWhiteBalanceIsNeutralAndLinear) {
  for (const double share : {0.1, 0.2, 0.4}) {
    const RawPhoto photo = Develop(GreyDng(camera_, share));
    ASSERT_EQ(photo.image.width, 48);
    ASSERT_EQ(photo.image.height, 32);
    for (const auto& [x, y] : {std::pair{0, 0}, {47, 31}, {20, 11}, {21, 11}, {20, 12}, {21, 12}}) {
      ExpectColor(photo.image.ColorAt(x, y), {share, share, share});
    }
    EXPECT_TRUE(photo.clipped.Empty());
    EXPECT_TRUE(photo.has_color_matrix);
    EXPECT_EQ(photo.white_balance, RawWhiteBalance::kCamera);
    EXPECT_NEAR(photo.multipliers.r, 2.0, 1e-5);
    EXPECT_EQ(photo.multipliers.g, 1.0);
    EXPECT_NEAR(photo.multipliers.b, 1.6, 1e-5);
  }
}

TEST_F(RawFile, BlackIsSubtractedWhateverItIs) {
  camera_.black = 2000;
  ExpectColor(Develop(GreyDng(camera_, 0.3)).image.ColorAt(10, 10), {0.3, 0.3, 0.3});
  EXPECT_EQ(MaxChannel(Develop(GreyDng(camera_, 0.0)).image.ColorAt(10, 10)), 0.0);
}

TEST_F(RawFile, BrightnessDoesNotHangOnWhatElseThePhotoShows) {
  const auto half_lit = [&](double other) {
    return DngBytes(camera_, [&, other](int x, int, int channel) {
      const double share = x < 24 ? 0.25 : other;
      return share * camera_.as_shot_neutral[static_cast<std::size_t>(channel)];
    });
  };
  for (const double other : {0.0, 0.25, 0.9}) {
    ExpectColor(Develop(half_lit(other)).image.ColorAt(8, 16), {0.25, 0.25, 0.25});
  }
}

TEST_F(RawFile, KnownColoursComeOutByTheMatrix) {
  // With the white of the matrix the camera's colour of white is neutral.
  const std::array<double, 3> white = CameraColor(camera_, {1.0, 1.0, 1.0});
  camera_.as_shot_neutral = white;
  for (const Rgb& color : {Rgb{0.5, 0.2, 0.1}, Rgb{0.1, 0.4, 0.2}, Rgb{0.15, 0.2, 0.6}}) {
    const std::array<double, 3> raw = CameraColor(camera_, color);
    const std::string bytes = DngBytes(camera_, [&](int, int, int channel) {
      return raw[static_cast<std::size_t>(channel)] / white[1];
    });
    // Green is the channel that is full at 1.
    ExpectColor(Develop(bytes).image.ColorAt(20, 15), color);
    const RawPhoto daylight = Develop(bytes, {.white_balance = RawWhiteBalance::kDaylight});
    ExpectColor(daylight.image.ColorAt(20, 15), color);
    EXPECT_NEAR(daylight.multipliers.r, white[1] / white[0], 1e-3);
    EXPECT_NEAR(daylight.multipliers.b, white[1] / white[2], 1e-3);
  }
}

TEST_F(RawFile, WithoutWhiteBalanceTheCamerasChannelsCountAlike) {
  const std::string bytes = DngBytes(camera_, [](int, int, int) { return 0.25; });
  const RawPhoto photo = Develop(bytes, {.white_balance = RawWhiteBalance::kNone});
  ExpectColor(photo.image.ColorAt(20, 15), {0.25, 0.25, 0.25});
  EXPECT_EQ(photo.multipliers.r, 1.0);
  EXPECT_EQ(photo.multipliers.b, 1.0);
}

TEST_F(RawFile, ChannelsAreNotCutWhereAnotherWouldBeFull) {
  const std::array<double, 3> white = CameraColor(camera_, {1.0, 1.0, 1.0});
  camera_.as_shot_neutral = white;
  const Rgb orange{1.5, 0.6, 0.1};
  const std::array<double, 3> raw = CameraColor(camera_, orange);
  const RawPhoto photo = Develop(DngBytes(camera_, [&](int, int, int channel) {
    return raw[static_cast<std::size_t>(channel)] / white[1];
  }));
  EXPECT_TRUE(photo.clipped.Empty());
  ExpectColor(photo.image.ColorAt(20, 15), orange);
}

TEST_F(RawFile, FullSensorValuesAreClippedWithTheirNeighbours) {
  const auto spot = [&](double share) {
    return DngBytes(camera_, [&, share](int x, int y, int channel) {
      return x == 20 && y == 10 ? share
                                : 0.2 * camera_.as_shot_neutral[static_cast<std::size_t>(channel)];
    });
  };
  const RawPhoto photo = Develop(spot(1.0));
  ASSERT_FALSE(photo.clipped.Empty());
  for (int y = 0; y < photo.clipped.height; ++y) {
    for (int x = 0; x < photo.clipped.width; ++x) {
      EXPECT_EQ(photo.clipped.At(x, y, 0),
                std::abs(x - 20) <= 1 && std::abs(y - 10) <= 1 ? 1.0F : 0.0F)
          << x << ' ' << y;
    }
  }
  // The level is a share of the range above black.
  EXPECT_TRUE(Develop(spot(0.98)).clipped.Empty());
  EXPECT_FALSE(Develop(spot(0.98), {.clip_above = 0.97}).clipped.Empty());
  EXPECT_TRUE(Develop(spot(1.0), {.clip_above = 1.0}).clipped.Empty());
}

TEST_F(RawFile, ValuesPileUpWhereTheSensorIsFull) {
  const auto ramp_to = [&](double brightest, double pile) {
    return DngBytes(camera_, [=](int x, int y, int /*channel*/) {
      // A sensor that is full below what its file says: what it holds differs by pixels.
      const double full = 0.9 * (1.0 + 0.002 * ((x + y) % 5 - 2));
      return x < pile ? full : brightest * x / 48.0;
    });
  };
  const RawPhoto photo = Develop(ramp_to(0.8, 10));
  ASSERT_FALSE(photo.clipped.Empty());
  for (int x = 0; x < photo.clipped.width; ++x) {
    EXPECT_EQ(photo.clipped.At(x, 7, 0), x <= 10 ? 1.0F : 0.0F) << x;
  }
  // Bright alone is not full, nor is a flat dark photo.
  EXPECT_TRUE(Develop(ramp_to(0.95, 0)).clipped.Empty());
  EXPECT_TRUE(Develop(DngBytes(camera_, [](int, int, int) { return 0.5; })).clipped.Empty());
}

TEST_F(RawFile, RowsStayAsStoredUnlessAskedOtherwise) {
  for (int orientation = 1; orientation <= 8; ++orientation) {
    camera_.orientation = orientation;
    const std::string bytes = DngBytes(
        camera_, [](int x, int y, int) { return x >= 40 && y < 8 ? 1.0 : 0.1 + 0.01 * x; });
    const RawPhoto stored = Develop(bytes);
    EXPECT_EQ(stored.exif_orientation, orientation);
    EXPECT_EQ(stored.image.width, 48);
    EXPECT_EQ(stored.clipped.At(47, 0, 0), 1.0F);
    const RawPhoto upright = Develop(bytes, {.apply_orientation = true});
    EXPECT_EQ(upright.image.data, ApplyOrientation(stored.image, orientation).data);
    EXPECT_EQ(upright.clipped.data, ApplyOrientation(stored.clipped, orientation).data);
  }
}

TEST_F(RawFile, SaysHowItWasExposed) {
  camera_.time_s = {1, 125};
  camera_.f_number = {8, 1};
  camera_.iso = 400;
  camera_.flash = true;
  const RawPhoto photo = Develop(GreyDng(camera_, 0.2));
  EXPECT_NEAR(photo.time_s, 0.008, 1e-7);
  EXPECT_NEAR(photo.f_number, 8.0, 1e-6);
  EXPECT_EQ(photo.iso, 400.0);
  EXPECT_TRUE(photo.flash);
  camera_.flash = false;
  EXPECT_FALSE(Develop(GreyDng(camera_, 0.2)).flash);
}

TEST_F(RawFile, BrokenFilesAreRefusedByName) {
  const std::string bytes = GreyDng(camera_, 0.2);
  const auto read = [](const std::filesystem::path& path) { ReadRawFile(path, {}); };
  const auto error = [&](const std::string& content) {
    return IoErrorOf([&] { read(folder_.Write("b.dng", content)); });
  };
  EXPECT_NE(error("no photo").find("b.dng: cannot be read as a RAW photo"), std::string::npos);
  EXPECT_NE(error("").find("b.dng"), std::string::npos);
  EXPECT_NE(IoErrorOf([&] { read(folder_.Path() / "none.dng"); }).find("none.dng"),
            std::string::npos);
  // The directory stands at the end.
  ExpectCutFilesRefused(folder_.Write("a.dng", bytes), bytes.size() - 300, 20, read);
  ExpectDamagedFilesSurvived(folder_.Path() / "a.dng", 60, read);
}

TEST_F(RawFile, IsNoOtherImage) {
  const std::filesystem::path path = folder_.Write("a.DNG", GreyDng(camera_, 0.2));
  EXPECT_NE(IoErrorOf([&] { ReadImageFile(path, false); }).find("a.DNG: RAW photos can be input"),
            std::string::npos);
}

TEST(RawExtension, IsToldInAnyLetters) {
  EXPECT_TRUE(HasRawExtension("a/IMG_1.CR2"));
  EXPECT_TRUE(HasRawExtension("b.nef"));
  EXPECT_FALSE(HasRawExtension("c.tif"));
  EXPECT_FALSE(HasRawExtension("dng"));
}

}  // namespace
}  // namespace pathfit::renderer::raw_file_test
