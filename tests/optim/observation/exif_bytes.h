#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace pathfit::optim {

/// What an EXIF block of a test says; rationals as they are stored.
struct ExifValues {
  std::uint32_t time[2] = {1, 60};
  std::uint32_t f_number[2] = {80, 10};
  std::uint16_t iso = 100;
  std::uint16_t flash = 0;
};

/// A TIFF structure whose first directory points to one with these values.
inline std::string ExifBlock(const ExifValues& values, bool big_endian = false) {
  std::string bytes = big_endian ? "MM" : "II";
  const auto put = [&](std::uint32_t value, int size) {
    for (int i = 0; i < size; ++i) {
      const int shift = 8 * (big_endian ? size - 1 - i : i);
      bytes.push_back(static_cast<char>((value >> shift) & 0xff));
    }
  };
  constexpr std::uint32_t kShort = 3, kLong = 4, kRational = 5;
  const auto entry = [&](std::uint32_t tag, std::uint32_t type, std::uint32_t value) {
    put(tag, 2);
    put(type, 2);
    put(1, 4);
    if (type == kShort) {
      put(value, 2);
      put(0, 2);
    } else {
      put(value, 4);
    }
  };
  put(42, 2);
  put(8, 4);
  put(1, 2);  // the first directory, at 8
  constexpr std::uint32_t kExifDirectory = 26, kValues = kExifDirectory + 2 + 4 * 12 + 4;
  entry(0x8769, kLong, kExifDirectory);
  put(0, 4);
  put(4, 2);
  entry(0x829a, kRational, kValues);
  entry(0x829d, kRational, kValues + 8);
  entry(0x8827, kShort, values.iso);
  entry(0x9209, kShort, values.flash);
  put(0, 4);
  for (const std::uint32_t part : values.time) put(part, 4);
  for (const std::uint32_t part : values.f_number) put(part, 4);
  return bytes;
}

/// A TIFF structure that says nothing but its colour space and, of three letters, how it is to be
/// understood.
inline std::string ColorBlock(char color_space, const std::string& interoperability) {
  using std::string_literals::operator""s;
  return "II\x2a\0\x08\0\0\0"s +                                      // at 8:
         "\1\0"s + "\x69\x87\4\0\1\0\0\0\x1a\0\0\0"s + "\0\0\0\0"s +  // at 26:
         "\2\0"s + "\x01\xa0\3\0\1\0\0\0"s + color_space + "\0\0\0"s +
         "\x05\xa0\4\0\1\0\0\0\x38\0\0\0"s + "\0\0\0\0"s +  // at 56:
         "\1\0"s + "\1\0\2\0\4\0\0\0"s + interoperability + "\0"s + "\0\0\0\0"s;
}

/// A JPEG file with this block behind its first two bytes.
inline std::string WithExif(const std::vector<unsigned char>& jpeg, const std::string& block) {
  std::string payload = std::string("Exif\0\0", 6) + block;
  const std::size_t size = payload.size() + 2;
  std::string bytes(jpeg.begin(), jpeg.begin() + 2);
  bytes += "\xff\xe1";
  bytes.push_back(static_cast<char>(size >> 8));
  bytes.push_back(static_cast<char>(size & 0xff));
  return bytes + payload + std::string(jpeg.begin() + 2, jpeg.end());
}

}  // namespace pathfit::optim
