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

AdjointSink::AdjointSink(const ParameterLayout& layout, const std::vector<Rgba>& weights, int width)
    : layout_(layout),
      weights_(weights),
      width_(width),
      rows_(weights.size() / static_cast<std::size_t>(width)) {}

void AdjointSink::Add(std::int64_t pixel, std::span<const ParameterDerivative> derivatives) {
  const Rgba& w = weights_[static_cast<std::size_t>(pixel)];
  // A row is rendered by one thread at a time, so rows need no lock.
  auto& row = rows_[static_cast<std::size_t>(pixel / width_)];
  for (const ParameterDerivative& entry : derivatives) {
    const int size = layout_.GroupOfBlock(entry.block).block_size;
    const std::int64_t scalar = layout_.FirstScalarOfBlock(entry.block);
    for (int c = 0; c < size; ++c) {
      const Rgba& d = entry.d[static_cast<std::size_t>(c)];
      row.emplace_back(scalar + c, w.r * d.r + w.g * d.g + w.b * d.b + w.a * d.a);
    }
  }
}

std::vector<double> AdjointSink::Gradient() const {
  std::vector<double> gradient(static_cast<std::size_t>(layout_.NumScalars()));
  for (const auto& row : rows_) {
    for (const auto& [scalar, value] : row) {
      gradient[static_cast<std::size_t>(scalar)] += value;
    }
  }
  return gradient;
}

}  // namespace pathfit::renderer
