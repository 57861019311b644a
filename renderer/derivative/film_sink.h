#pragma once

#include <cstddef>
#include <deque>
#include <span>
#include <vector>

#include "renderer/derivative/derivative_sink.h"
#include "renderer/image/image.h"
#include "renderer/scene/parameter_layout.h"

namespace pathfit::renderer {

/// Derivative image in one direction of parameter space: each pixel's derivative times `direction`,
/// a flat vector over the layout's scalars.
class FilmSink : public DerivativeSink {
 public:
  FilmSink(const ParameterLayout& layout, std::vector<double> direction, int width, int height);
  void Add(std::int64_t pixel, std::span<const ParameterDerivative> derivatives) override;
  [[nodiscard]] const Film& film() const { return film_; }

 private:
  std::vector<double> block_direction_;  // three per block, padded with zeros
  Film film_;
};

/// The same in several directions, from one rendering.
class FilmSinks : public DerivativeSink {
 public:
  FilmSinks(const ParameterLayout& layout,
            std::span<const std::vector<double>> directions,
            int width,
            int height);
  void Add(std::int64_t pixel, std::span<const ParameterDerivative> derivatives) override {
    for (FilmSink& sink : sinks_) sink.Add(pixel, derivatives);
  }
  [[nodiscard]] const Film& film(std::size_t direction) const { return sinks_[direction].film(); }

 private:
  std::deque<FilmSink> sinks_;
};

}  // namespace pathfit::renderer
