#pragma once

#include <array>
#include <cstddef>

#include "renderer/sensor/camera.h"

namespace pathfit::renderer {

/// One axis of a filter at offset `d` pixels from the pixel's centre: integrates to one, zero
/// outside the radius. The filter of a pixel is the product of both axes. With |d| <= r:
/// box 1 / 2r, tent (1 - |d| / r) / r, Gaussian (exp(-d^2 / 2 s^2) - exp(-r^2 / 2 s^2)) / norm.
double FilterProfile(const PixelFilter& filter, double d);
/// Its derivative by d, where there is one; zero for the box and at the tent's three corners.
double FilterSlope(const PixelFilter& filter, double d);
/// Offset with density FilterProfile from a uniform number in [0, 1): the inverse of the
/// distribution function, increasing in `u`; the function's value at the offset is u to 1e-14.
double SampleFilter(const PixelFilter& filter, double u);

/// Pixels of a row of `size` whose filter covers coordinate `at`: [first, end).
struct CoveringRange {
  int first = 0, end = 0;
};
CoveringRange CoveringPixels(const PixelFilter& filter, double at, int size);

/// Pixels whose filter covers image point (u, v), in order; calls visit(x, y, weight) for each that
/// lies on a film of width x height. The box of radius 0.5 visits the one pixel that holds the
/// point; its left and upper border belong to a pixel. (u, v) may lie outside the film.
template <class Visit>
void ForEachCoveringPixel(
    const PixelFilter& filter, double u, double v, int width, int height, Visit visit) {
  const CoveringRange columns = CoveringPixels(filter, u, width);
  const CoveringRange rows = CoveringPixels(filter, v, height);
  if (columns.first >= columns.end) return;
  // The largest radius, 8, covers 16 pixels of a row; one more where both ends round outwards.
  std::array<double, 17> weights_x{};
  for (int x = columns.first; x < columns.end; ++x) {
    weights_x[static_cast<std::size_t>(x - columns.first)] = FilterProfile(filter, u - (x + 0.5));
  }
  for (int y = rows.first; y < rows.end; ++y) {
    const double weight_y = FilterProfile(filter, v - (y + 0.5));
    for (int x = columns.first; x < columns.end; ++x) {
      const double weight = weight_y * weights_x[static_cast<std::size_t>(x - columns.first)];
      if (weight > 0.0) visit(x, y, weight);
    }
  }
}

}  // namespace pathfit::renderer
