#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/world.h"

namespace pathfit::renderer {

/// Pixels [x0, x1) x [y0, y1).
struct PixelBounds {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  [[nodiscard]] bool Contains(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
  [[nodiscard]] std::int64_t NumPixels() const {
    return static_cast<std::int64_t>(x1 - x0) * (y1 - y0);
  }
};

/// A rectangle outside which no pixel's filter sees one of the meshes with wanted[mesh] (all if
/// `wanted` is empty); the whole image where that is not sure.
PixelBounds BoundsOfMeshes(const World& world,
                           const CameraModel& camera,
                           const std::vector<bool>& wanted = {});

}  // namespace pathfit::renderer
