#pragma once

#include <cstddef>
#include <vector>

#include "renderer/math/rgb.h"

namespace pathfit::renderer {

/// Float image, row-major and interleaved. Pixel (x, y) is x from the left, y from the top, both
/// from 0; its centre has the camera's coordinates (x + 0.5, y + 0.5). Colours are red, green, blue
/// of linear Rec.709 unless a function says otherwise; one channel is a mask or coverage.
///
/// `data` has width * height * channels numbers; whoever changes a size changes it, too. No member
/// checks its indices.
struct Image {
  int width = 0;            ///< pixels
  int height = 0;           ///< pixels
  int channels = 0;         ///< numbers per pixel
  std::vector<float> data;  ///< data[(y * width + x) * channels + c]

  /// No pixel and no channel.
  Image() = default;
  /// Black. No size may be negative.
  Image(int w, int h, int c)
      : width(w),
        height(h),
        channels(c),
        data(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) *
             static_cast<std::size_t>(c)) {}

  /// Place of a pixel's first channel in `data`.
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
  /// The first three channels, which the image must have.
  [[nodiscard]] Rgb ColorAt(int x, int y) const {
    const float* p = data.data() + Offset(x, y);
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
  }
  /// Whether there is no number at all.
  [[nodiscard]] bool Empty() const { return data.empty(); }
};

/// Rendered pixels in double precision, in the order of an Image: pixels[y * width + x]. r, g, b
/// are the radiance seen through the pixel's filter times Camera::gain, linear Rec.709, not
/// clipped; a is coverage, the share of the filter that sees an object, the environment being none.
struct Film {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  std::vector<Rgba> pixels;

  /// No pixel.
  Film() = default;
  /// Black, covered nowhere. No size may be negative.
  Film(int w, int h)
      : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
};

/// r, g, b of a film, rounded to float: 3 channels of the same size. Empty of an empty film.
Image ColorImage(const Film& film);
/// Coverage of a film, rounded to float: 1 channel of the same size. Empty of an empty film.
Image CoverageImage(const Film& film);

}  // namespace pathfit::renderer
