#pragma once

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

}  // namespace pathfit::renderer
