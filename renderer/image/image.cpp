#include "renderer/image/image.h"

namespace pathfit::renderer {

Image ColorImage(const Film& film) {
  Image image(film.width, film.height, 3);
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      image.data[3 * i + static_cast<std::size_t>(c)] = static_cast<float>(film.pixels[i][c]);
    }
  }
  return image;
}

Image CoverageImage(const Film& film) {
  Image image(film.width, film.height, 1);
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    image.data[i] = static_cast<float>(film.pixels[i].a);
  }
  return image;
}

}  // namespace pathfit::renderer
