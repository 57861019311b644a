#include <array>
#include <cmath>
#include <cstddef>

#include "renderer/sensor/camera.h"

namespace pathfit::renderer {
namespace {

constexpr std::size_t kFx = 0, kFy = 1, kCx = 2, kCy = 3, kFirstLens = 4;
constexpr std::size_t kNumLens = 5;  // k1 k2 k3 p1 p2

/// Derivative of the distorted point by each lens number, at a fixed undistorted point.
std::array<Vec2, kNumLens> PointByLens(const Vec2& u) {
  const double r2 = u.x * u.x + u.y * u.y;
  const double xy2 = 2.0 * u.x * u.y;
  return {u * r2,
          u * (r2 * r2),
          u * (r2 * r2 * r2),
          {xy2, r2 + 2.0 * u.y * u.y},
          {r2 + 2.0 * u.x * u.x, xy2}};
}

/// Change of the entries of the distortion's symmetric Jacobian.
struct JacobianChange {
  double xx, xy, yy;
};

std::array<JacobianChange, kNumLens> JacobianByLens(const Vec2& u) {
  const double r2 = u.x * u.x + u.y * u.y;
  std::array<JacobianChange, kNumLens> out{};
  double power = 1.0;  // r2^(k - 1)
  for (std::size_t k = 1; k <= 3; ++k) {
    const double slope = 2.0 * static_cast<double>(k) * power;
    power *= r2;
    out[k - 1] = {power + slope * u.x * u.x, slope * u.x * u.y, power + slope * u.y * u.y};
  }
  out[3] = {2.0 * u.y, 2.0 * u.x, 6.0 * u.y};
  out[4] = {6.0 * u.x, 2.0 * u.y, 2.0 * u.x};
  return out;
}

std::array<JacobianChange, 2> JacobianByPoint(const LensDistortion& d, const Vec2& u) {
  const double r2 = u.x * u.x + u.y * u.y;
  const double s = 2.0 * (d.k1 + r2 * (2.0 * d.k2 + 3.0 * r2 * d.k3));
  const double t = 4.0 * (2.0 * d.k2 + 6.0 * r2 * d.k3);
  // Third derivatives of the potential: they do not depend on the order.
  const double xxy = s * u.y + t * u.x * u.x * u.y + 2.0 * d.p1;
  const double xyy = s * u.x + t * u.x * u.y * u.y + 2.0 * d.p2;
  return {JacobianChange{3.0 * s * u.x + t * u.x * u.x * u.x + 6.0 * d.p2, xxy, xyy},
          JacobianChange{xxy, xyy, 3.0 * s * u.y + t * u.y * u.y * u.y + 6.0 * d.p1}};
}

double DeterminantChange(const Distorted& j, const JacobianChange& d) {
  return j.yy * d.xx + j.xx * d.yy - 2.0 * j.xy * d.xy;
}

}  // namespace

CameraModel::RayIntrinsics CameraModel::RayByIntrinsics(double u, double v) const {
  const Vec2 distorted{(u - camera_.cx) / camera_.fx, (v - camera_.cy) / camera_.fy};
  const Vec2 x = Undistort(distorted);
  const Distorted lens = Distort(camera_.distortion, x);
  const double scale = 1.0 / lens.Determinant();
  // A fixed pixel: what the numbers would do to the distorted point, the undistorted one undoes.
  const auto undistorted_change = [&](const Vec2& change) {
    return Vec2{(lens.yy * change.x - lens.xy * change.y) * scale,
                (lens.xx * change.y - lens.xy * change.x) * scale};
  };
  std::array<Vec2, kNumIntrinsics> dx{};
  dx[kFx] = undistorted_change({-distorted.x / camera_.fx, 0.0});
  dx[kFy] = undistorted_change({0.0, -distorted.y / camera_.fy});
  dx[kCx] = undistorted_change({-1.0 / camera_.fx, 0.0});
  dx[kCy] = undistorted_change({0.0, -1.0 / camera_.fy});
  RayIntrinsics out;
  const Mat3& axes = pose_.linear;
  if (IsOrthographic()) {
    for (std::size_t i = 0; i < kFirstLens; ++i) {
      out.origin[i] = axes.x * dx[i].x - axes.y * dx[i].y;
    }
    return out;
  }
  const std::array<Vec2, kNumLens> by_lens = PointByLens(x);
  for (std::size_t k = 0; k < kNumLens; ++k) {
    dx[kFirstLens + k] = undistorted_change(by_lens[k] * -1.0);
  }
  const double inverse_length = 1.0 / std::sqrt(1.0 + x.x * x.x + x.y * x.y);
  const Vec3 direction = (axes.x * x.x - axes.y * x.y - axes.z) * inverse_length;
  for (std::size_t i = 0; i < dx.size(); ++i) {
    const Vec3 d = (axes.x * dx[i].x - axes.y * dx[i].y) * inverse_length;
    out.direction[i] = d - direction * Dot(direction, d);
  }
  return out;
}

std::array<Vec2, CameraModel::kNumIntrinsics> CameraModel::PixelByIntrinsics(
    const Vec3& x_in_world) const {
  std::array<Vec2, kNumIntrinsics> out{};
  const auto x = NormalizedOf(x_in_world);
  if (!x) return out;
  const Vec2 distorted = Distort(camera_.distortion, *x).value;
  out[kFx].x = distorted.x;
  out[kFy].y = distorted.y;
  out[kCx].x = 1.0;
  out[kCy].y = 1.0;
  if (!IsOrthographic()) {
    const std::array<Vec2, kNumLens> by_lens = PointByLens(*x);
    for (std::size_t k = 0; k < kNumLens; ++k) {
      out[kFirstLens + k] = {camera_.fx * by_lens[k].x, camera_.fy * by_lens[k].y};
    }
  }
  return out;
}

// With u = cx + fx D(x) the density is fx fy |det D'(x)| times the area ratio of the normalised
// coordinates x: |n . y| / depth^3 for y from the centre, |n . axis| for parallel rays.
CameraModel::PixelDensity CameraModel::DensityAt(const Vec3& x_in_world, const Vec3& n) const {
  PixelDensity out;
  const auto x = NormalizedOf(x_in_world);
  if (!x) return out;
  const Mat3& axes = pose_.linear;
  const Vec3 y = IsOrthographic() ? axes.z : x_in_world - Origin();
  const double facing = Dot(n, y);
  if (facing == 0.0) return out;
  out.value = camera_.fx * camera_.fy * std::abs(facing);
  out.d_n = y / facing;
  out.d_intrinsics[kFx] = 1.0 / camera_.fx;
  out.d_intrinsics[kFy] = 1.0 / camera_.fy;
  if (IsOrthographic()) return out;
  const double inverse_depth = -1.0 / Dot(axes.z, y);
  out.value *= inverse_depth * inverse_depth * inverse_depth;
  out.d_x = n / facing + axes.z * (3.0 * inverse_depth);
  const Distorted lens = Distort(camera_.distortion, *x);
  const double determinant = lens.Determinant();
  const std::array<JacobianChange, kNumLens> by_lens = JacobianByLens(*x);
  for (std::size_t k = 0; k < kNumLens; ++k) {
    out.d_intrinsics[kFirstLens + k] = DeterminantChange(lens, by_lens[k]) / determinant;
  }
  if (distorted_) {
    out.value *= std::abs(determinant);
    const std::array<JacobianChange, 2> by_point = JacobianByPoint(camera_.distortion, *x);
    const double by_x = DeterminantChange(lens, by_point[0]) * inverse_depth / determinant;
    const double by_y = DeterminantChange(lens, by_point[1]) * inverse_depth / determinant;
    out.d_x += (axes.x + axes.z * x->x) * by_x + (axes.z * x->y - axes.y) * by_y;
  }
  return out;
}

}  // namespace pathfit::renderer
