#pragma once

#include <cstdint>

namespace pathfit::renderer {

/// Numerical non-events of a rendering: samples dropped, never silently.
struct RenderStats {
  std::int64_t paths = 0;
  std::int64_t non_finite_samples = 0;  ///< dropped interior samples with NaN or infinity
  std::int64_t edge_samples = 0;
  std::int64_t edge_samples_hidden = 0;  ///< edge point not visible from the sensor
};

}  // namespace pathfit::renderer
