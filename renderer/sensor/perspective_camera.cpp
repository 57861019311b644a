#include "renderer/sensor/perspective_camera.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/core/error.h"

namespace pathfit::renderer {
namespace {

constexpr int kMaxNewtonSteps = 20;
constexpr double kNewtonTolerance = 1e-14;
// Field of view kept beyond the image corners, so that edges crossing the frame still project.
constexpr double kFieldMargin = 1.05;
constexpr double kRotationTolerance = 1e-6;

struct Distorted {
  Vec2 value;
  double xx, xy, yx, yy;  // d value / d undistorted
};

Distorted Distort(const LensDistortion& d, const Vec2& u) {
  const double r2 = u.x * u.x + u.y * u.y;
  const double radial = 1.0 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
  const double slope = d.k1 + r2 * (2.0 * d.k2 + 3.0 * r2 * d.k3);  // d radial / d r2
  const double xy = u.x * u.y;
  Distorted out;
  out.value = {u.x * radial + 2.0 * d.p1 * xy + d.p2 * (r2 + 2.0 * u.x * u.x),
               u.y * radial + d.p1 * (r2 + 2.0 * u.y * u.y) + 2.0 * d.p2 * xy};
  const double cross = 2.0 * slope * xy + 2.0 * d.p1 * u.x + 2.0 * d.p2 * u.y;
  out.xx = radial + 2.0 * slope * u.x * u.x + 2.0 * d.p1 * u.y + 6.0 * d.p2 * u.x;
  out.xy = cross;
  out.yx = cross;
  out.yy = radial + 2.0 * slope * u.y * u.y + 6.0 * d.p1 * u.y + 2.0 * d.p2 * u.x;
  return out;
}

void Require(bool condition, const PerspectiveCamera& camera, const char* what) {
  if (!condition) {
    throw SceneError("camera '" + camera.name + "': " + what);
  }
}

void ValidateCamera(const PerspectiveCamera& c) {
  Require(c.width > 0 && c.height > 0, c, "width and height must be positive");
  const std::array<double, 9> numbers = {c.fx,
                                         c.fy,
                                         c.cx,
                                         c.cy,
                                         c.distortion.k1,
                                         c.distortion.k2,
                                         c.distortion.k3,
                                         c.distortion.p1,
                                         c.distortion.p2};
  Require(std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); }),
          c,
          "intrinsics must be finite");
  Require(c.fx > 0.0 && c.fy > 0.0, c, "focal lengths must be positive");
  Require(std::isfinite(c.gain) && c.gain > 0.0, c, "exposure gain must be positive");
  const Mat3& m = c.world_from_camera.linear;
  Require(
      IsFinite(m.x) && IsFinite(m.y) && IsFinite(m.z) && IsFinite(c.world_from_camera.translation),
      c,
      "pose must be finite");
  const Mat3 product = Transposed(m) * m;
  const double error = std::max({Norm(product.x - Vec3{1, 0, 0}),
                                 Norm(product.y - Vec3{0, 1, 0}),
                                 Norm(product.z - Vec3{0, 0, 1}),
                                 std::abs(Determinant(m) - 1.0)});
  Require(error < kRotationTolerance, c, "pose must be a rotation and a translation");
}

}  // namespace

CameraModel::CameraModel(const PerspectiveCamera& camera)
    : camera_(camera), camera_from_world_(RigidInverse(camera.world_from_camera)) {
  ValidateCamera(camera_);
  // The largest view angle is met on the border; walk it, since distortion bends it.
  constexpr int kSteps = 32;
  max_radius_ = 1e9;
  double radius = 0.0;
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i <= kSteps; ++i) {
      const double s = static_cast<double>(i) / kSteps;
      const double u = side < 2 ? s * camera_.width : (side == 2 ? 0.0 : camera_.width);
      const double v = side >= 2 ? s * camera_.height : (side == 0 ? 0.0 : camera_.height);
      const Vec2 x = Undistort({(u - camera_.cx) / camera_.fx, (v - camera_.cy) / camera_.fy});
      radius = std::max(radius, std::hypot(x.x, x.y));
    }
  }
  max_radius_ = kFieldMargin * radius;
  for (int i = 0; i <= kSteps && !camera_.distortion.IsNone(); ++i) {
    for (int j = 0; j < 8; ++j) {
      const double r = max_radius_ * i / kSteps;
      const double angle = 0.7853981633974483 * j;
      const Distorted d = Distort(camera_.distortion, {r * std::cos(angle), r * std::sin(angle)});
      Require(d.xx * d.yy - d.xy * d.yx > 0.0, camera_, "lens distortion folds inside the image");
    }
  }
}

Vec2 CameraModel::Undistort(const Vec2& distorted) const {
  if (camera_.distortion.IsNone()) {
    return distorted;
  }
  Vec2 u = distorted;
  for (int i = 0; i < kMaxNewtonSteps; ++i) {
    const Distorted d = Distort(camera_.distortion, u);
    const Vec2 error = d.value - distorted;
    const double determinant = d.xx * d.yy - d.xy * d.yx;
    Require(determinant > 0.0, camera_, "lens distortion folds inside the image");
    const Vec2 step = {(d.yy * error.x - d.xy * error.y) / determinant,
                       (d.xx * error.y - d.yx * error.x) / determinant};
    u = u - step;
    if (step.x * step.x + step.y * step.y < kNewtonTolerance * kNewtonTolerance) {
      return u;
    }
  }
  Require(std::isfinite(u.x) && std::isfinite(u.y), camera_, "lens distortion cannot be inverted");
  return u;
}

Ray CameraModel::RayThrough(double u, double v) const {
  const Vec2 x = Undistort({(u - camera_.cx) / camera_.fx, (v - camera_.cy) / camera_.fy});
  const Vec3 in_camera{x.x, -x.y, -1.0};
  return {Origin(), Normalized(camera_.world_from_camera.Direction(in_camera))};
}

std::optional<Projection> CameraModel::Project(const Vec3& x_in_world) const {
  const Vec3 p = camera_from_world_.Point(x_in_world);
  const double depth = -p.z;
  if (!(depth > 0.0)) {
    return std::nullopt;
  }
  const double inverse = 1.0 / depth;
  const Vec2 n{p.x * inverse, -p.y * inverse};
  if (n.x * n.x + n.y * n.y > max_radius_ * max_radius_) {
    return std::nullopt;
  }
  const Distorted d = Distort(camera_.distortion, n);
  // Rows of the rotation are the camera axes in the world.
  const Mat3& axes = camera_.world_from_camera.linear;
  const Vec3 dx = (axes.x + axes.z * n.x) * inverse;
  const Vec3 dy = (axes.z * n.y - axes.y) * inverse;
  Projection out;
  out.u = camera_.cx + camera_.fx * d.value.x;
  out.v = camera_.cy + camera_.fy * d.value.y;
  out.du = (dx * d.xx + dy * d.xy) * camera_.fx;
  out.dv = (dx * d.yx + dy * d.yy) * camera_.fy;
  out.depth = depth;
  return out;
}

Vec2 CameraModel::PixelOf(const Vec2& normalized) const {
  const Vec2 d = Distort(camera_.distortion, normalized).value;
  return {camera_.cx + camera_.fx * d.x, camera_.cy + camera_.fy * d.y};
}

PerspectiveCamera ScaledCamera(const PerspectiveCamera& camera, int width, int height) {
  PerspectiveCamera out = camera;
  const double sx = static_cast<double>(width) / camera.width;
  const double sy = static_cast<double>(height) / camera.height;
  out.width = width;
  out.height = height;
  out.fx *= sx;
  out.cx *= sx;
  out.fy *= sy;
  out.cy *= sy;
  return out;
}

PerspectiveCamera CroppedCamera(
    const PerspectiveCamera& camera, int x0, int y0, int width, int height) {
  PerspectiveCamera out = camera;
  out.width = width;
  out.height = height;
  out.cx -= x0;
  out.cy -= y0;
  return out;
}

}  // namespace pathfit::renderer
