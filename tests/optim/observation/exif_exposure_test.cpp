#include "optim/observation/exif_exposure.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/optim/observation/exif_bytes.h"

namespace pathfit::optim::exif_exposure_test {
namespace {

using std::string_literals::operator""s;

void ExpectPlausible(const std::optional<ExifExposure>& exposure) {
  if (!exposure) return;
  EXPECT_TRUE(std::isfinite(exposure->Ev()));
  EXPECT_GT(exposure->time_s, 0.0);
  EXPECT_GT(exposure->f_number, 0.0);
  EXPECT_GT(exposure->iso, 0.0);
}

TEST(ExifExposure, ReadsTimeApertureAndIsoInBothByteOrders) {
  for (const bool big_endian : {false, true}) {
    const auto exposure = ParseExifExposure(
        ExifBlock({.time = {1, 125}, .f_number = {56, 10}, .iso = 400, .flash = 0x19}, big_endian));
    ASSERT_TRUE(exposure);
    EXPECT_DOUBLE_EQ(exposure->time_s, 1.0 / 125.0);
    EXPECT_DOUBLE_EQ(exposure->f_number, 5.6);
    EXPECT_DOUBLE_EQ(exposure->iso, 400.0);
    EXPECT_TRUE(exposure->flash);
  }
}

TEST(ExifExposure, TwiceTheTimeOrSensitivityIsOneStopMore) {
  const double ev = ExifExposure{0.01, 8.0, 100.0}.Ev();
  EXPECT_NEAR((ExifExposure{0.02, 8.0, 100.0}).Ev() - ev, 1.0, 1e-12);
  EXPECT_NEAR((ExifExposure{0.01, 8.0, 200.0}).Ev() - ev, 1.0, 1e-12);
  EXPECT_NEAR((ExifExposure{0.01, 4.0, 100.0}).Ev() - ev, 2.0, 1e-12);
}

TEST(ExifExposure, ImplausibleValuesCountAsNone) {
  EXPECT_FALSE(ParseExifExposure(ExifBlock({.time = {0, 60}})));
  EXPECT_FALSE(ParseExifExposure(ExifBlock({.time = {1, 0}})));
  EXPECT_FALSE(ParseExifExposure(ExifBlock({.time = {0xffffffff, 1}})));
  EXPECT_FALSE(ParseExifExposure(ExifBlock({.f_number = {0, 10}}))) << "a lens without contacts";
  EXPECT_FALSE(ParseExifExposure(ExifBlock({.iso = 0})));
  EXPECT_FALSE(ParseExifExposure(ExifBlock({.iso = 65535}))) << "means that it stands elsewhere";
  EXPECT_FALSE(ParseExifExposure(""));
  EXPECT_FALSE(ParseExifExposure("no TIFF structure at all"));
}

TEST(ExifExposure, DamagedBytesNeverCrash) {
  for (const bool big_endian : {false, true}) {
    const std::string whole = ExifBlock({}, big_endian);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      EXPECT_FALSE(ParseExifExposure(whole.substr(0, size))) << "cut at " << size;
    }
    for (std::size_t i = 0; i < whole.size(); ++i) {
      for (const int value : {0x00, 0x01, 0x7f, 0x80, 0xff, whole[i] ^ 0x10}) {
        std::string damaged = whole;
        damaged[i] = static_cast<char>(value);
        ExpectPlausible(ParseExifExposure(damaged));
      }
    }
  }
}

// With the notes of a maker, whose own formats the library tries to read, and what else tags lead
// to.
TEST(ExifExposure, RandomBytesNeverCrash) {
  std::mt19937 random(7);
  const std::string makers[] = {"Nikon\0\2\0\0\0"s,
                                "OLYMP\0\1\0"s,
                                "FUJIFILM\x0c\0\0\0"s,
                                "AOC\0MM"s,
                                "SANYO\0"s,
                                "EPSON\0"s};
  for (int round = 0; round < 1000; ++round) {
    std::string block = ExifBlock({}, round % 2 == 0);
    // The entry of the flash becomes one of notes that lie behind.
    const std::size_t entry = block.size() - 16 - 4 - 12;
    if (round % 3 == 0) {
      std::string notes = makers[random() % 6];
      while (notes.size() < 200) notes.push_back(static_cast<char>(random()));
      const bool big = round % 2 == 0;
      const std::string numbers = big ? std::string("\x92\x7c\0\7\0\0\0\xc8\0\0\0", 11)
                                      : std::string("\x7c\x92\7\0\xc8\0\0\0", 8);
      std::string tag = numbers;
      const char offset = static_cast<char>(block.size());
      tag += big ? std::string(1, offset) : std::string(1, offset) + std::string(3, '\0');
      block.replace(entry, 12, tag);
      block += notes;
    }
    const int changes = static_cast<int>(random() % 12);
    for (int i = 0; i < changes; ++i) {
      block[8 + random() % (block.size() - 8)] = static_cast<char>(random());
    }
    ExpectPlausible(ParseExifExposure(block));
  }
  ExpectPlausible(ParseExifExposure(ExifBlock({}) + std::string(1 << 20, '\xff')));
}

TEST(ExifColors, AreAdobeRgbWhereTheyAreSaidToBe) {
  EXPECT_TRUE(NamesAdobeRgb(ColorBlock('\xff', "R03")));
  EXPECT_TRUE(NamesAdobeRgb(ColorBlock('\2', "R98")));
  EXPECT_FALSE(NamesAdobeRgb(ColorBlock('\1', "R98")));
  EXPECT_FALSE(NamesAdobeRgb(ExifBlock({})));
  EXPECT_FALSE(NamesAdobeRgb(""));
  const std::string whole = ColorBlock('\1', "R03");
  for (std::size_t size = 0; size < whole.size() - 8; ++size) {
    EXPECT_FALSE(NamesAdobeRgb(whole.substr(0, size))) << "cut at " << size;
  }
}

TEST(ExifExposures, AreDifferencesAroundTheirMean) {
  const auto found = CompareExifExposures({ExifExposure{1.0 / 60, 8.0, 100.0},
                                           ExifExposure{1.0 / 30, 8.0, 100.0},
                                           ExifExposure{1.0 / 30, 8.0, 200.0}});
  ASSERT_EQ(found.ev.size(), 3U);
  EXPECT_NEAR(found.ev[0], -1.0, 1e-9);
  EXPECT_NEAR(found.ev[1], 0.0, 1e-9);
  EXPECT_NEAR(found.ev[2], 1.0, 1e-9);
  EXPECT_EQ(found.seen,
            "EXIF: 3 of 3 photos with an exposure: 1/60 to 1/30 s, f/8, ISO 100 to 200; they "
            "differ by 2 EV.");
}

TEST(ExifExposures, AreNotUsedWhereTheyTellNothing) {
  const ExifExposure one{1.0 / 60, 8.0, 100.0};
  ExifExposure other{1.0 / 15, 8.0, 100.0};
  EXPECT_TRUE(CompareExifExposures({}).seen.empty());
  EXPECT_TRUE(CompareExifExposures({std::nullopt, std::nullopt}).seen.empty());

  const auto check = [](const std::vector<std::optional<ExifExposure>>& photos,
                        const char* reason) {
    const ExifComparison found = CompareExifExposures(photos);
    EXPECT_TRUE(found.ev.empty());
    EXPECT_NE(found.seen.find(reason), std::string::npos) << found.seen;
  };
  check({one, one}, "alike");
  check({one, ExifExposure{1.0 / 64, 8.0, 100.0}}, "alike");
  check({one, other, std::nullopt}, "the others have none");
  check({one, ExifExposure{30.0, 1.0, 100.0}}, "too much");
  other.flash = true;
  check({one, other}, "flash");
}

TEST(ExifLens, NamesCameraAndFocalLength) {
  // Little endian: a directory with Make, Model and the place of the other one, which has the focal
  // length as 505 / 10.
  std::string block = "II*";
  const auto put = [&](std::uint32_t value, int size) {
    for (int i = 0; i < size; ++i) block.push_back(static_cast<char>(value >> (8 * i) & 0xff));
  };
  const auto entry =
      [&](std::uint32_t tag, std::uint32_t type, std::uint32_t count, std::uint32_t v) {
        put(tag, 2);
        put(type, 2);
        put(count, 4);
        put(v, 4);
      };
  constexpr std::uint32_t kAscii = 2, kLong = 4, kRational = 5;
  put(0, 1);
  put(8, 4);
  put(3, 2);
  entry(0x010f, kAscii, 4, 0x00656341);  // "Ace"
  entry(0x0110, kAscii, 4, 0x0000394b);  // "K9"
  entry(0x8769, kLong, 1, 50);
  put(0, 4);
  put(1, 2);
  entry(0x920a, kRational, 1, 68);
  put(0, 4);
  put(505, 4);
  put(10, 4);
  EXPECT_EQ(ParseExifLens(block), "Ace K9, 50.5 mm");
  for (std::size_t size = 0; size < block.size(); ++size) {
    EXPECT_NE(ParseExifLens(block.substr(0, size)), "Ace K9, 50.5 mm");
  }
  EXPECT_EQ(ParseExifLens(ExifBlock({})), "");
  EXPECT_EQ(ParseExifLens(""), "");
}

}  // namespace
}  // namespace pathfit::optim::exif_exposure_test
