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

/// Gradient of a scalar: sum over pixels and channels of weight * derivative, as a flat vector over
/// the layout.
class AdjointSink : public DerivativeSink {
 public:
  /// `weights`: dLoss / dPixel of each channel, one per pixel; must outlive the sink.
  AdjointSink(const ParameterLayout& layout, const std::vector<Rgba>& weights, int width);
  void Add(std::int64_t pixel, std::span<const ParameterDerivative> derivatives) override;
  /// Summed row by row in a fixed order.
  [[nodiscard]] std::vector<double> Gradient() const;

 private:
  const ParameterLayout& layout_;
  const std::vector<Rgba>& weights_;
  int width_;
  std::vector<std::vector<std::pair<std::int64_t, double>>> rows_;  // (scalar, value) per image row
};

}  // namespace pathfit::renderer
