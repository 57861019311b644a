#include "app/output/signed_image.h"

#include <algorithm>
#include <cmath>

namespace pathfit::app {

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
    const auto fade = static_cast<float>(1.0 - std::min(1.0, std::abs(value)));
    image.data[3 * i] = value < 0.0 ? fade : 1.0F;
    image.data[3 * i + 1] = fade;
    image.data[3 * i + 2] = value > 0.0 ? fade : 1.0F;
  }
  return image;
}

}  // namespace pathfit::app
