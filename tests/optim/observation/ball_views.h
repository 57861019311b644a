#pragma once

#include <cmath>
#include <string>

#include "optim/observation/observation.h"
#include "renderer/geometry/mesh.h"
#include "renderer/sensor/camera.h"
#include "tests/optim/observation/observation_files.h"

namespace pathfit::optim {

inline constexpr renderer::Vec3 kCenter{0.3, -0.2, 11.1};
inline constexpr double kRadius = 0.5;
inline constexpr int kSize = 96;

inline renderer::Camera CameraAt(const renderer::Vec3& origin, const renderer::Vec3& target) {
  renderer::Camera camera;
  camera.width = camera.height = kSize;
  camera.fx = camera.fy = 180.0;
  camera.cx = 0.5 * kSize + 3.0;
  camera.cy = 0.5 * kSize - 2.0;
  camera.distortion.k1 = 0.1;
  camera.world_from_camera = LookAt(
      origin,
      target,
      std::abs(origin.y - target.y) > 2.0 ? renderer::Vec3{1, 0, 0} : renderer::Vec3{0, 1, 0});
  return camera;
}

/// Exact coverage of a ball up to 4x4 samples per pixel.
inline renderer::Image BallMask(const renderer::Camera& camera,
                                const renderer::Vec3& center,
                                double radius) {
  const renderer::CameraModel model(camera);
  renderer::Image mask(camera.width, camera.height, 1);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      int hits = 0;
      for (int s = 0; s < 16; ++s) {
        const int column = s % 4;
        const int row = s / 4;
        const renderer::Ray ray = model.RayThrough(x + (column + 0.5) / 4.0, y + (row + 0.5) / 4.0);
        hits += Norm(Cross(ray.direction, center - ray.origin)) < radius ? 1 : 0;
      }
      mask.At(x, y, 0) = static_cast<float>(hits) / 16.0F;
    }
  }
  return mask;
}

inline View BallView(const renderer::Vec3& direction) {
  View view;
  view.camera =
      CameraAt(kCenter + Normalized(direction) * 3.0, kCenter + renderer::Vec3{0.05, 0.02, -0.03});
  view.photo = ConstantImage(kSize, kSize, 3, 0.5F);
  view.mask = BallMask(view.camera, kCenter, kRadius);
  return view;
}

/// Views from the corners of an icosahedron.
inline ObservationSet BallFromAllSides() {
  ObservationSet set;
  set.mask_meaning = MaskMeaning::kSilhouette;
  for (const renderer::Vec3& corner : renderer::MakeIcosphere(0, 1.0).positions) {
    set.views.push_back(BallView(corner));
    set.views.back().name = "view" + std::to_string(set.views.size());
  }
  return set;
}

}  // namespace pathfit::optim
