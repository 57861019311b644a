#pragma once

#include <algorithm>
#include <cmath>

#include "renderer/sensor/camera.h"

namespace pathfit::optim {

/// The camera with pictures whose longer side has at most so many pixels.
inline renderer::Camera ReducedCamera(const renderer::Camera& camera, double longest_px) {
  const double scale = std::min(1.0, longest_px / std::max(camera.width, camera.height));
  const auto reduced = [scale](int size) {
    return std::max(1, static_cast<int>(std::lround(scale * size)));
  };
  return renderer::ScaledCamera(camera, reduced(camera.width), reduced(camera.height));
}

}  // namespace pathfit::optim
