#include "renderer/scene/view_bounds.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace pathfit::renderer {
namespace {

constexpr int kStepsPerSide = 64;
constexpr double kMarginPx = 1.0;

/// Normalised image coordinates [low, high], as CameraModel::PixelOf takes them.
struct Box {
  Vec2 low{1e300, 1e300};
  Vec2 high{-1e300, -1e300};
};

/// Box of all vertices; empty if one of them has no image.
std::optional<Box> NormalizedBox(const World& world,
                                 const CameraModel& camera,
                                 const std::vector<bool>& wanted) {
  const Transform camera_from_world = RigidInverse(camera.Pose());
  Box out;
  for (int i = 0; i < world.NumMeshes(); ++i) {
    if (!wanted.empty() && !wanted[static_cast<std::size_t>(i)]) {
      continue;
    }
    for (const Vec3& x : world.mesh(i).positions) {
      const Vec3 p = camera_from_world.Point(x);
      // Parallel rays: what lies behind the plane is not seen, and does not upset the rest.
      const double depth = camera.IsOrthographic() ? 1.0 : -p.z;
      if (!(depth > 0.0)) {
        return std::nullopt;
      }
      const Vec2 n{p.x / depth, -p.y / depth};
      out.low = {std::min(out.low.x, n.x), std::min(out.low.y, n.y)};
      out.high = {std::max(out.high.x, n.x), std::max(out.high.y, n.y)};
    }
  }
  return out;
}

}  // namespace

PixelBounds BoundsOfMeshes(const World& world,
                           const CameraModel& camera,
                           const std::vector<bool>& wanted) {
  const int width = camera.camera().width;
  const int height = camera.camera().height;
  const PixelBounds whole{0, 0, width, height};
  // A triangle's undistorted image lies in the box of its corners; only afterwards does distortion
  // bend the box.
  const auto box = NormalizedBox(world, camera, wanted);
  if (!box) {
    return whole;
  }
  auto [low, high] = *box;
  const double field = camera.MaxTangent();
  if (low.x > field || low.y > field || high.x < -field || high.y < -field) {
    return {};
  }
  if (std::hypot(std::max(-low.x, high.x), std::max(-low.y, high.y)) > field) {
    // A lens polynomial means nothing out there.
    if (!camera.camera().distortion.IsNone()) {
      return whole;
    }
    low = {std::max(low.x, -field), std::max(low.y, -field)};
    high = {std::min(high.x, field), std::min(high.y, field)};
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
  const double reach = kMarginPx + std::max(0.0, camera.camera().filter.radius - 0.5);
  const double margin_x = reach + (last.x - first.x) / kStepsPerSide;
  const double margin_y = reach + (last.y - first.y) / kStepsPerSide;
  const auto clamped = [](double v, int size) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(size)));
  };
  return {clamped(std::floor(first.x - margin_x), width),
          clamped(std::floor(first.y - margin_y), height),
          clamped(std::ceil(last.x + margin_x), width),
          clamped(std::ceil(last.y + margin_y), height)};
}

}  // namespace pathfit::renderer
