#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "renderer/math/rgb.h"
#include "renderer/render_options.h"

namespace pathfit::renderer {

/// Derivative of one pixel (colour and coverage) by one parameter block of a ParameterLayout;
/// components beyond the block's size are zero.
struct ParameterDerivative {
  std::int32_t block = -1;
  std::array<Rgba, 3> d;
};

/// Listens to the estimators. Estimators do not know what becomes of their samples.
class DerivativeSink {
 public:
  DerivativeSink() = default;
  DerivativeSink(const DerivativeSink&) = delete;
  DerivativeSink& operator=(const DerivativeSink&) = delete;
  virtual ~DerivativeSink() = default;

  /// What follows is of `term`, drawn with so many samples (rays, where one has several); called
  /// before any Add, once per term that has samples.
  virtual void BeginTerm(DerivativeTerm /*term*/, std::int64_t /*num_samples*/) {}
  /// Adds to the derivative of a pixel (index y * width + x). Calls for different image rows may
  /// come from different threads at once; calls for one row come one after another, and for one
  /// pixel in an order fixed by the seed.
  virtual void Add(std::int64_t pixel, std::span<const ParameterDerivative> derivatives) = 0;
};

}  // namespace pathfit::renderer
