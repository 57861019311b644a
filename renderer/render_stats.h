#pragma once

#include <cstdint>

namespace pathfit::renderer {

/// Numerical non-events of a rendering: samples dropped, never silently.
struct RenderStats {
  std::int64_t paths = 0;
  std::int64_t non_finite_samples = 0;  ///< dropped interior samples with NaN or infinity
  std::int64_t edge_samples = 0;
  std::int64_t edge_samples_hidden = 0;  ///< edge point not visible from the sensor

  RenderStats& operator+=(const RenderStats& s) {
    paths += s.paths;
    non_finite_samples += s.non_finite_samples;
    edge_samples += s.edge_samples;
    edge_samples_hidden += s.edge_samples_hidden;
    return *this;
  }
};

}  // namespace pathfit::renderer
