#include "renderer/derivative/film_sink.h"

#include "renderer/core/check.h"

namespace pathfit::renderer {

FilmSink::FilmSink(const ParameterLayout& layout,
                   std::vector<double> direction,
                   int width,
                   int height)
    : film_(width, height) {
  PATHFIT_CHECK(direction.size() == static_cast<std::size_t>(layout.NumScalars()));
  block_direction_.resize(3 * static_cast<std::size_t>(layout.NumBlocks()));
  for (const ParameterGroup& group : layout.groups()) {
    for (std::int32_t i = 0; i < group.num_blocks; ++i) {
      for (int c = 0; c < group.block_size; ++c) {
        const auto scalar = static_cast<std::size_t>(group.first_scalar + i * group.block_size + c);
        block_direction_[static_cast<std::size_t>(3 * (group.first_block + i) + c)] =
            direction[scalar];
      }
    }
  }
}

void FilmSink::Add(std::int64_t pixel, std::span<const ParameterDerivative> derivatives) {
  Rgba sum;
  for (const ParameterDerivative& entry : derivatives) {
    const double* direction = block_direction_.data() + 3 * entry.block;
    for (std::size_t c = 0; c < 3; ++c) {
      sum += entry.d[c] * direction[c];
    }
  }
  film_.pixels[static_cast<std::size_t>(pixel)] += sum;
}

FilmSinks::FilmSinks(const ParameterLayout& layout,
                     std::span<const std::vector<double>> directions,
                     int width,
                     int height) {
  for (const std::vector<double>& direction : directions) {
    sinks_.emplace_back(layout, direction, width, height);
  }
}

}  // namespace pathfit::renderer
