#pragma once

#include <cstddef>
#include <vector>

#include "renderer/math/rgb.h"

namespace pathfit::renderer {

/// Interleaved float image, row 0 on top. Values are linear Rec.709 unless a function says
/// otherwise.
struct Image {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<float> data;  ///< data[(y * width + x) * channels + c]

  Image() = default;
  Image(int w, int h, int c)
      : width(w),
        height(h),
        channels(c),
        data(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) *
             static_cast<std::size_t>(c)) {}

  [[nodiscard]] std::size_t Offset(int x, int y) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
            static_cast<std::size_t>(x)) *
           static_cast<std::size_t>(channels);
  }
  [[nodiscard]] float& At(int x, int y, int c) {
    return data[Offset(x, y) + static_cast<std::size_t>(c)];
  }
  [[nodiscard]] float At(int x, int y, int c) const {
    return data[Offset(x, y) + static_cast<std::size_t>(c)];
  }
  /// The first three channels.
  [[nodiscard]] Rgb ColorAt(int x, int y) const {
    const float* p = data.data() + Offset(x, y);
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
  }
  [[nodiscard]] bool Empty() const { return data.empty(); }
};

/// Rendered pixels: radiance times the sensor's gain, and coverage. Row 0 on top.
struct Film {
  int width = 0;
  int height = 0;
  std::vector<Rgba> pixels;

  Film() = default;
  Film(int w, int h)
      : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
};

/// Colour (3 channels) and coverage (1 channel) of a film.
Image ColorImage(const Film& film);
Image CoverageImage(const Film& film);

}  // namespace pathfit::renderer
