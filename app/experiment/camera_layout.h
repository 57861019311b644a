#pragma once

#include <optional>
#include <vector>

#include "renderer/sensor/camera.h"

namespace pathfit::app {

/// What cameras that look at one thing say about where it is and how large, without its picture.
struct CameraLayout {
  renderer::Vec3 centre;  ///< nearest to the viewing axes, by least squares
  double distance = 0.0;  ///< of the cameras from it, mean
  /// Median radius of the balls about `centre` that fill the pictures up to the nearest border; 0
  /// if most cameras do not have `centre` in their picture.
  double radius = 0.0;
  int num_behind = 0;  ///< cameras that look away from `centre`
};

/// Empty without cameras, and when the axes are so nearly parallel that they meet nowhere.
std::optional<CameraLayout> FindCameraLayout(const std::vector<renderer::Camera>& cameras);

}  // namespace pathfit::app
