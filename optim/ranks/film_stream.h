#pragma once

#include "optim/ranks/byte_stream.h"
#include "renderer/image/image.h"

namespace pathfit::optim {

template <>
struct Parts<renderer::Film> {
  static void Visit(auto& film, const auto& visit) {
    visit(film.width);
    visit(film.height);
    visit(film.pixels);
  }
};

}  // namespace pathfit::optim
