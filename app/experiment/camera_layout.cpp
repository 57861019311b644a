#include "app/experiment/camera_layout.h"

#include <algorithm>
#include <cmath>

namespace pathfit::app {
namespace {

using renderer::Camera;
using renderer::Mat3;
using renderer::Transform;
using renderer::Vec3;

// Smallest eigenvalue of the mean projector off the axes, roughly: the square of a small angle.
constexpr double kParallel = 1e-6;

/// Radius of the ball about x that reaches the nearest border of the picture; negative outside.
double RadiusInPicture(const Camera& camera, const Vec3& x_in_camera) {
  const double depth = -x_in_camera.z;
  const double u = camera.cx + camera.fx * x_in_camera.x / depth;
  const double v = camera.cy - camera.fy * x_in_camera.y / depth;
  return depth * std::min({u / camera.fx,
                           (camera.width - u) / camera.fx,
                           v / camera.fy,
                           (camera.height - v) / camera.fy});
}

}  // namespace

std::optional<CameraLayout> FindCameraLayout(const std::vector<Camera>& cameras) {
  const auto count = static_cast<double>(cameras.size());
  Mat3 sum{{}, {}, {}};
  Vec3 right;
  for (const Camera& camera : cameras) {
    const Transform pose = renderer::CameraPose(camera);
    const Vec3 axis = pose.linear.z;  // of either sign
    const auto off_axis = [&](const Vec3& x) { return (x - axis * Dot(axis, x)) * (1.0 / count); };
    sum = {sum.x + off_axis({1.0, 0.0, 0.0}),
           sum.y + off_axis({0.0, 1.0, 0.0}),
           sum.z + off_axis({0.0, 0.0, 1.0})};
    right += off_axis(pose.translation);
  }
  const double determinant = Determinant(sum);
  if (cameras.empty() || !(determinant > kParallel)) return std::nullopt;
  CameraLayout layout;
  layout.centre = Vec3{Dot(Cross(sum.y, sum.z), right),
                       Dot(Cross(sum.z, sum.x), right),
                       Dot(Cross(sum.x, sum.y), right)} *
                  (1.0 / determinant);
  std::vector<double> radii;
  for (const Camera& camera : cameras) {
    const Vec3 x = renderer::RigidInverse(renderer::CameraPose(camera)).Point(layout.centre);
    layout.distance += Norm(x) / count;
    if (x.z >= 0.0) {
      ++layout.num_behind;
      radii.push_back(0.0);
    } else {
      radii.push_back(RadiusInPicture(camera, x));
    }
  }
  std::ranges::nth_element(radii, radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2));
  layout.radius = std::max(0.0, radii[radii.size() / 2]);
  return layout;
}

}  // namespace pathfit::app
