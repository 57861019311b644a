#pragma once

#include "optim/ranks/byte_stream.h"
#include "renderer/image/image.h"

namespace pathfit::optim {

inline void Write(const renderer::Film& film, ByteWriter& writer) {
  writer.Put(film.width);
  writer.Put(film.height);
  writer.Put(film.pixels);
}

inline void Read(ByteReader& reader, renderer::Film& film) {
  reader.Get(film.width);
  reader.Get(film.height);
  reader.Get(film.pixels);
}

}  // namespace pathfit::optim
