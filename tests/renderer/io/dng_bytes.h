#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/math/rgb.h"

namespace pathfit::renderer {

/// A camera of whose RAW files everything is known.
struct DngCamera {
  int width = 48, height = 32;
  int black = 512, white = 16512;
  int orientation = 1;
  /// Camera colours of XYZ under D65, rows.
  std::array<std::array<double, 3>, 3> camera_from_xyz{
      {{0.6, 0.05, -0.1}, {-0.3, 1.2, 0.1}, {-0.05, 0.15, 0.6}}};
  std::array<double, 3> as_shot_neutral{0.5, 1.0, 0.625};
  std::array<int, 2> time_s{1, 60}, f_number{56, 10};
  int iso = 200;
  bool flash = false;
};

/// Of a colour in linear Rec.709 (IEC 61966-2-1), what this camera's channels say.
inline std::array<double, 3> CameraColor(const DngCamera& camera, const Rgb& color) {
  constexpr double kXyz[3][3] = {{0.4124564, 0.3575761, 0.1804375},
                                 {0.2126729, 0.7151522, 0.0721750},
                                 {0.0193339, 0.1191920, 0.9503041}};
  std::array<double, 3> result{};
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < 3; ++k) {
      result[c] += camera.camera_from_xyz[c][k] *
                   (kXyz[k][0] * color.r + kXyz[k][1] * color.g + kXyz[k][2] * color.b);
    }
  }
  return result;
}

/// Share of the range from black to white of channel 0 to 2 at a pixel.
using DngShare = std::function<double(int x, int y, int channel)>;

/// An uncompressed DNG of 16 bits whose filter is RG/GB.
inline std::string DngBytes(const DngCamera& camera, const DngShare& share) {
  struct Entry {
    int tag, type;  // 1 byte, 2 text, 3 short, 4 long, 5 rational, 10 with sign
    std::uint32_t count;
    std::string data;
  };
  const auto number = [](std::uint32_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>((value >> (8 * i)) & 255U);
    return text;
  };
  const auto rational = [&](int over, int under) {
    return number(static_cast<std::uint32_t>(over), 4) +
           number(static_cast<std::uint32_t>(under), 4);
  };
  const auto whole = [&](int tag, int value) {
    return Entry{tag, 4, 1, number(static_cast<std::uint32_t>(value), 4)};
  };
  const auto text = [](int tag, std::string value) {
    value += '\0';
    return Entry{tag, 2, static_cast<std::uint32_t>(value.size()), value};
  };
  // A directory, whose longer values follow it.
  const auto directory = [&](const std::vector<Entry>& entries, std::uint32_t at) {
    std::string head = number(static_cast<std::uint32_t>(entries.size()), 2);
    std::string tail;
    const auto end = static_cast<std::uint32_t>(at + 2 + 12 * entries.size() + 4);
    for (const Entry& entry : entries) {
      head += number(static_cast<std::uint32_t>(entry.tag), 2) +
              number(static_cast<std::uint32_t>(entry.type), 2) + number(entry.count, 4);
      if (entry.data.size() <= 4) {
        head += entry.data + std::string(4 - entry.data.size(), '\0');
      } else {
        head += number(end + static_cast<std::uint32_t>(tail.size()), 4);
        tail += entry.data + std::string(entry.data.size() % 2, '\0');
      }
    }
    return head + number(0, 4) + tail;
  };

  std::string pixels;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const int channel = x % 2 + y % 2;  // R G, G B
      const double value = camera.black + share(x, y, channel) * (camera.white - camera.black);
      pixels += number(static_cast<std::uint32_t>(
                           std::lround(std::clamp(value, 0.0, static_cast<double>(camera.white)))),
                       2);
    }
  }
  constexpr std::uint32_t kPixels = 8;
  const auto exif_at = static_cast<std::uint32_t>(kPixels + pixels.size());
  const std::string exif =
      directory({{33434, 5, 1, rational(camera.time_s[0], camera.time_s[1])},
                 {33437, 5, 1, rational(camera.f_number[0], camera.f_number[1])},
                 {34855, 3, 1, number(static_cast<std::uint32_t>(camera.iso), 2)},
                 {37385, 3, 1, number(camera.flash ? 1 : 0, 2)}},
                exif_at);
  std::string matrix, neutral;
  constexpr int kUnder = 1000000;
  for (const auto& row : camera.camera_from_xyz) {
    for (const double v : row)
      matrix += rational(static_cast<int>(std::lround(v * kUnder)), kUnder);
  }
  for (const double v : camera.as_shot_neutral) {
    neutral += rational(static_cast<int>(std::lround(v * kUnder)), kUnder);
  }
  const auto at = static_cast<std::uint32_t>(exif_at + exif.size());
  const std::string main =
      directory({whole(254, 0),
                 whole(256, camera.width),
                 whole(257, camera.height),
                 {258, 3, 1, number(16, 2)},
                 {259, 3, 1, number(1, 2)},
                 {262, 3, 1, number(32803, 2)},
                 text(271, "Pathfit"),
                 text(272, "Known Camera"),
                 whole(273, kPixels),
                 {274, 3, 1, number(static_cast<std::uint32_t>(camera.orientation), 2)},
                 {277, 3, 1, number(1, 2)},
                 whole(278, camera.height),
                 whole(279, static_cast<int>(pixels.size())),
                 {284, 3, 1, number(1, 2)},
                 {33421, 3, 2, number(2, 2) + number(2, 2)},
                 {33422, 1, 4, std::string("\0\1\1\2", 4)},
                 whole(34665, static_cast<int>(exif_at)),
                 {50706, 1, 4, std::string("\1\4\0\0", 4)},
                 text(50708, "Pathfit Known Camera"),
                 whole(50714, camera.black),
                 whole(50717, camera.white),
                 {50721, 10, 9, matrix},
                 {50728, 5, 3, neutral},
                 {50778, 3, 1, number(21, 2)}},
                at);
  return "II" + number(42, 2) + number(at, 4) + pixels + exif + main;
}

/// Grey under the camera's white balance: of this share everywhere in green.
inline std::string GreyDng(const DngCamera& camera, double share) {
  return DngBytes(camera, [&](int, int, int channel) {
    return share * camera.as_shot_neutral[static_cast<std::size_t>(channel)];
  });
}

}  // namespace pathfit::renderer
