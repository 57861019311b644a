#pragma once

#include <array>
#include <vector>

#include "renderer/sensor/camera.h"

namespace pathfit::tests {

/// Intrinsics of the axe photographs (data set axe_turntable, first sensor).
inline renderer::Camera AxeCamera() {
  renderer::Camera camera;
  camera.name = "axe";
  camera.width = 1024;
  camera.height = 683;
  camera.fx = 2400.1110774652225;
  camera.fy = 2401.2830067022664;
  camera.cx = 516.4634165229311;
  camera.cy = 304.13975884046266;
  camera.distortion = {0.05228029183302142, 1.4826426326959588, -12.25221025290341, 0.0, 0.0};
  camera.world_from_camera = {{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}, {0, 0, 0}};
  return camera;
}

inline renderer::Camera BarrelCamera() {
  renderer::Camera camera;
  camera.name = "wide";
  camera.width = 200;
  camera.height = 120;
  camera.fx = 110.0;
  camera.fy = 105.0;
  camera.cx = 95.0;
  camera.cy = 64.0;
  camera.distortion = {-0.20, 0.06, -0.005, 0.01, -0.015};
  camera.world_from_camera = renderer::LookAt({0.4, -0.3, 2.0}, {0.1, 0.0, 0.0}, {0.1, 1.0, 0.0});
  return camera;
}

inline renderer::Camera PincushionCamera() {
  renderer::Camera camera = BarrelCamera();
  camera.name = "pincushion, turned";
  camera.distortion = {0.35, -0.1, 0.02, -0.02, 0.01};
  camera.rotation = {0.3, -0.2, 0.5};
  return camera;
}

inline renderer::Camera PinholeCamera() {
  renderer::Camera camera = BarrelCamera();
  camera.name = "pinhole, turned";
  camera.distortion = {};
  camera.rotation = {-0.4, 1.1, 0.2};
  return camera;
}

/// About the same view as the others, at 2 m.
inline renderer::Camera ParallelCamera() {
  renderer::Camera camera = PinholeCamera();
  camera.name = "parallel, turned";
  camera.projection = renderer::ProjectionKind::kOrthographic;
  camera.fx = 55.0;
  camera.fy = 52.0;
  return camera;
}

inline std::vector<renderer::Camera> AllCameras() {
  return {AxeCamera(), BarrelCamera(), PincushionCamera(), PinholeCamera(), ParallelCamera()};
}

/// The numbers inside a camera, in the order of CameraModel::kNumIntrinsics.
inline std::array<double, 9> IntrinsicsOf(const renderer::Camera& c) {
  return {c.fx,
          c.fy,
          c.cx,
          c.cy,
          c.distortion.k1,
          c.distortion.k2,
          c.distortion.k3,
          c.distortion.p1,
          c.distortion.p2};
}
inline renderer::Camera WithIntrinsic(const renderer::Camera& camera, int i, double value) {
  renderer::Camera c = camera;
  const std::array<double*, 9> numbers = {&c.fx,
                                          &c.fy,
                                          &c.cx,
                                          &c.cy,
                                          &c.distortion.k1,
                                          &c.distortion.k2,
                                          &c.distortion.k3,
                                          &c.distortion.p1,
                                          &c.distortion.p2};
  *numbers[static_cast<std::size_t>(i)] = value;
  return c;
}
/// Intrinsics that may change: a parallel camera has no distortion.
inline int NumFreeIntrinsics(const renderer::Camera& camera) {
  return camera.projection == renderer::ProjectionKind::kOrthographic ? 4 : 9;
}

}  // namespace pathfit::tests
