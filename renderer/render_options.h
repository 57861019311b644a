#pragma once

#include <cstdint>

#include "renderer/core/parallel.h"

namespace pathfit::renderer {

/// Which estimators of the derivative run.
struct DerivativeTerms {
  bool interior = true;
  bool primary = true;
};

/// Budgets and seed of one rendering. Names follow the field: spp interior samples per pixel, sppe
/// primary-edge samples per pixel of edge length.
struct RenderOptions {
  std::uint64_t seed = 0;
  std::uint64_t view = 0;  ///< key of the random streams; usually the index of the view
  int spp = 16;
  double sppe = 4.0;
  int max_bounces = 1;  ///< 0 = only what the sensor sees of the environment, 1 = direct light
  int rr_depth = 5;     ///< Russian roulette from this bounce on
  DerivativeTerms terms;
  const CancelFlag* cancel = nullptr;  ///< polled per image row; throws Cancelled
};

}  // namespace pathfit::renderer
