#include "renderer/scene/view_bounds.h"

#include <algorithm>
#include <cmath>

namespace pathfit::renderer {
namespace {

constexpr int kStepsPerSide = 64;
constexpr double kNearDepth = 1e-9;
constexpr double kMarginPx = 1.0;

}  // namespace

PixelBounds BoundsOfMeshes(const Scene& scene, const CameraModel& camera) {
  const int width = camera.camera().width;
  const int height = camera.camera().height;
  const PixelBounds whole{0, 0, width, height};
  const Transform camera_from_world = RigidInverse(camera.camera().world_from_camera);
  // A triangle's undistorted image lies in the box of its corners; only afterwards does distortion
  // bend the box.
  Vec2 low{1e300, 1e300};
  Vec2 high{-1e300, -1e300};
  for (const SceneMesh& m : scene.meshes) {
    for (const Vec3& x : m.mesh.positions) {
      const Vec3 p = camera_from_world.Point(x);
      if (-p.z <= kNearDepth) {
        return whole;
      }
      const Vec2 n{p.x / -p.z, p.y / p.z};
      low = {std::min(low.x, n.x), std::min(low.y, n.y)};
      high = {std::max(high.x, n.x), std::max(high.y, n.y)};
    }
  }
  if (low.x > high.x) {
    return {};
  }
  if (std::hypot(std::max(-low.x, high.x), std::max(-low.y, high.y)) > camera.MaxTangent()) {
    return whole;
  }
  Vec2 first{1e300, 1e300};
  Vec2 last{-1e300, -1e300};
  for (int i = 0; i <= kStepsPerSide; ++i) {
    const double s = static_cast<double>(i) / kStepsPerSide;
    const double x = low.x + s * (high.x - low.x);
    const double y = low.y + s * (high.y - low.y);
    for (const Vec2& n : {Vec2{x, low.y}, Vec2{x, high.y}, Vec2{low.x, y}, Vec2{high.x, y}}) {
      const Vec2 pixel = camera.PixelOf(n);
      first = {std::min(first.x, pixel.x), std::min(first.y, pixel.y)};
      last = {std::max(last.x, pixel.x), std::max(last.y, pixel.y)};
    }
  }
  // Between two steps the bent side bulges by far less than a step.
  const double margin_x = kMarginPx + (last.x - first.x) / kStepsPerSide;
  const double margin_y = kMarginPx + (last.y - first.y) / kStepsPerSide;
  const auto clamped = [](double v, int size) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(size)));
  };
  return {clamped(std::floor(first.x - margin_x), width),
          clamped(std::floor(first.y - margin_y), height),
          clamped(std::ceil(last.x + margin_x), width),
          clamped(std::ceil(last.y + margin_y), height)};
}

}  // namespace pathfit::renderer
