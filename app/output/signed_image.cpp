#include "app/output/signed_image.h"

#include <algorithm>
#include <cmath>

#include "app/output/scale_bar.h"

namespace pathfit::app {
namespace {

/// -1 blue, 0 white, 1 red.
std::array<float, 3> SignedColor(double value) {
  const auto fade = static_cast<float>(1.0 - std::min(1.0, std::abs(value)));
  return {value < 0.0 ? fade : 1.0F, fade, value > 0.0 ? fade : 1.0F};
}

}  // namespace

double SignedScale(const renderer::Film& film) {
  std::vector<double> values;
  for (const renderer::Rgba& p : film.pixels) {
    values.push_back(std::abs(renderer::Luminance(p.Color())));
  }
  if (values.empty()) {
    return 0.0;
  }
  std::sort(values.begin(), values.end());
  const double percentile =
      values[static_cast<std::size_t>(0.995 * static_cast<double>(values.size() - 1))];
  return percentile > 0.0 ? percentile : values.back();
}

renderer::Image SignedImage(const renderer::Film& film, double scale) {
  renderer::Image image(film.width, film.height, 3);
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const double value = scale > 0.0 ? renderer::Luminance(film.pixels[i].Color()) / scale : 0.0;
    const std::array<float, 3> color = SignedColor(value);
    std::copy(color.begin(), color.end(), image.data.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  return WithScaleBar(image, scale, SignedColor);
}

}  // namespace pathfit::app
