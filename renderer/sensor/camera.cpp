#include "renderer/sensor/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>

#include "renderer/core/error.h"

namespace pathfit::renderer {
namespace {

constexpr int kMaxNewtonSteps = 20;
constexpr double kNewtonTolerance = 1e-8;  // of a step, whose square is what it leaves
// Field of view kept beyond the image corners, so that edges crossing the frame still project.
constexpr double kFieldMargin = 1.05;
constexpr double kRotationTolerance = 1e-6;
constexpr double kMaxRotation = 1e6;
constexpr double kMaxFilterRadius = 8.0;
constexpr double kMinSigma = 1e-3;
constexpr double kMaxSigma = 1e3;
constexpr double kLargestVignetting = 20.0;

void Require(bool condition, const Camera& camera, const char* what) {
  if (!condition) throw SceneError("camera '" + camera.name + "': " + what);
}

/// Of its logarithm either way, among radii as dense as they need to be for a cubic.
double LargestVignetting(const Camera& c) {
  if (c.vignetting.IsNone()) return 0.0;
  double farthest = 0.0;
  for (const int x : {0, c.width - 1}) {
    for (const int y : {0, c.height - 1}) {
      farthest = std::max(farthest, c.VignettingRadius2(x, y));
    }
  }
  constexpr int kRadii = 64;
  double largest = 0.0;
  for (int i = 0; i <= kRadii; ++i) {
    largest = std::max(largest, std::abs(c.vignetting.LogAt(farthest * i / kRadii)));
  }
  return largest;
}

void ValidateCamera(const Camera& c) {
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
  Require(std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); }),
          c,
          "intrinsics must be finite");
  Require(c.fx > 0.0 && c.fy > 0.0, c, "focal lengths must be positive");
  // Tangents of pixels, or metres for parallel rays.
  Require(IsWithinBounds({std::max(std::abs(c.cx), 1.0 * c.width) / c.fx,
                          std::max(std::abs(c.cy), 1.0 * c.height) / c.fy,
                          0.0}),
          c,
          "focal lengths must be above 1e-12 of the image's size and of its principal point");
  Require(std::isfinite(c.gain) && c.gain > 0.0, c, "exposure gain must be positive");
  Require(std::isfinite(c.red) && c.red > 0.0 && std::isfinite(c.blue) && c.blue > 0.0,
          c,
          "factors of white balance must be positive");
  Require(std::isfinite(c.vignetting.v1) && std::isfinite(c.vignetting.v2) &&
              std::isfinite(c.vignetting.v3) && LargestVignetting(c) <= kLargestVignetting,
          c,
          "vignetting must be a factor within exp(-20) and exp(20)");
  const Mat3& m = c.world_from_camera.linear;
  Require(IsFinite(m.x) && IsFinite(m.y) && IsFinite(m.z), c, "pose must be finite");
  Require(IsWithinBounds(c.world_from_camera.translation),
          c,
          "its place must be finite, no coordinate beyond 1e12 metres");
  const Mat3 product = Transposed(m) * m;
  const double error = std::max({Norm(product.x - Vec3{1, 0, 0}),
                                 Norm(product.y - Vec3{0, 1, 0}),
                                 Norm(product.z - Vec3{0, 0, 1}),
                                 std::abs(Determinant(m) - 1.0)});
  Require(error < kRotationTolerance, c, "pose must be a rotation and a translation");
  // A number beyond the bound has lost its angle to rounding; also false for NaN.
  Require(Norm(c.rotation) < kMaxRotation, c, "rotation must be finite, below 1e6 radians");
  Require(c.filter.radius > 0.0 && c.filter.radius <= kMaxFilterRadius,
          c,
          "filter radius must be above 0 and at most 8 pixels");
  Require(c.filter.shape != PixelFilter::Shape::kGaussian ||
              (c.filter.sigma >= kMinSigma && c.filter.sigma <= kMaxSigma),
          c,
          "sigma of a Gaussian filter must lie in [0.001, 1000] pixels");
  Require(c.projection == ProjectionKind::kPerspective || c.distortion.IsNone(),
          c,
          "an orthographic camera has no lens distortion");
}

}  // namespace

Transform CameraPose(const Camera& camera) {
  const Transform& t = camera.world_from_camera;
  if (camera.rotation == Vec3{}) return t;
  return {RotationFromVector(camera.rotation) * t.linear, t.translation};
}

bool IsOff(const std::vector<int>& lights_off, int emitter) {
  return std::binary_search(lights_off.begin(), lights_off.end(), emitter);
}

bool HaveSameLens(const Camera& a, const Camera& b) {
  const auto lens = [](const Camera& c) {
    return std::tie(
        c.projection, c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.distortion, c.vignetting);
  };
  return lens(a) == lens(b);
}

CameraModel::CameraModel(const Camera& camera)
    : camera_(camera),
      distorted_(!camera.distortion.IsNone()),
      pose_(CameraPose(camera)),
      camera_from_world_(RigidInverse(pose_)) {
  ValidateCamera(camera_);
  max_radius_ = kFieldMargin * FieldRadius();
  constexpr int kRings = 32;
  constexpr int kSpokes = 8;
  bool is_near = distorted_;  // the series nowhere leads further off than no lens at all
  const NearInverse inverse = NearInverse::Of(camera_.distortion);
  for (int i = 0; i <= kRings && distorted_; ++i) {
    for (int j = 0; j < kSpokes; ++j) {
      const double r = max_radius_ * i / kRings;
      const double angle = 2.0 * std::numbers::pi * j / kSpokes;
      const Vec2 u{r * std::cos(angle), r * std::sin(angle)};
      const Distorted d = Distort(camera_.distortion, u);
      Require(d.Determinant() > 0.0,
              camera_,
              "lens distortion folds inside the image (or within the filter's reach around it)");
      const Vec2 left = inverse.Undo(d.value) - u;
      const Vec2 lens = d.value - u;
      is_near = is_near && std::hypot(left.x, left.y) <= std::hypot(lens.x, lens.y);
    }
  }
  if (is_near) near_inverse_ = inverse;
}

// The largest view angle is met on the border; walk it, since distortion bends it.
double CameraModel::FieldRadius() const {
  constexpr int kSteps = 32;
  const double reach = std::max(0.0, camera_.filter.radius - 0.5);
  double radius = 0.0;
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i <= kSteps; ++i) {
      const double s = static_cast<double>(i) / kSteps;
      const double along_u = s * camera_.width + reach * (2.0 * s - 1.0);
      const double along_v = s * camera_.height + reach * (2.0 * s - 1.0);
      const double u = side < 2 ? along_u : (side == 2 ? -reach : camera_.width + reach);
      const double v = side >= 2 ? along_v : (side == 0 ? -reach : camera_.height + reach);
      const Vec2 x = Undistort({(u - camera_.cx) / camera_.fx, (v - camera_.cy) / camera_.fy});
      radius = std::max(radius, std::hypot(x.x, x.y));
    }
  }
  return radius;
}

Vec2 CameraModel::Undistort(const Vec2& distorted) const {
  if (!distorted_) return distorted;
  Vec2 u = near_inverse_.Undo(distorted);
  for (int i = 0; i < kMaxNewtonSteps; ++i) {
    const Distorted d = Distort(camera_.distortion, u);
    const Vec2 error = d.value - distorted;
    const double determinant = d.Determinant();
    Require(determinant > 0.0,
            camera_,
            "lens distortion folds inside the image (or within the filter's reach around it)");
    const Vec2 step = {(d.yy * error.x - d.xy * error.y) / determinant,
                       (d.xx * error.y - d.xy * error.x) / determinant};
    u = u - step;
    if (step.x * step.x + step.y * step.y < kNewtonTolerance * kNewtonTolerance) return u;
  }
  Require(std::isfinite(u.x) && std::isfinite(u.y), camera_, "lens distortion cannot be inverted");
  return u;
}

Ray CameraModel::RayTo(const Vec3& x_in_world, double& distance) const {
  const Vec3 to_center = Origin() - x_in_world;
  if (IsOrthographic()) {
    distance = Dot(pose_.linear.z, to_center);
    return {x_in_world, pose_.linear.z};
  }
  distance = Norm(to_center);
  return {x_in_world, distance > 0.0 ? to_center / distance : pose_.linear.z};
}

std::optional<Vec2> CameraModel::NormalizedOf(const Vec3& x_in_world) const {
  const Vec3 p = camera_from_world_.Point(x_in_world);
  if (!(p.z < 0.0)) return std::nullopt;
  const double scale = IsOrthographic() ? 1.0 : -1.0 / p.z;
  const Vec2 n{p.x * scale, -p.y * scale};
  if (!(n.x * n.x + n.y * n.y <= max_radius_ * max_radius_)) return std::nullopt;
  return n;
}

std::optional<Projection> CameraModel::Project(const Vec3& x_in_world) const {
  const Vec3 p = camera_from_world_.Point(x_in_world);
  const double depth = -p.z;
  if (!(depth > 0.0)) return std::nullopt;
  const bool parallel = IsOrthographic();
  const double inverse = parallel ? 1.0 : 1.0 / depth;
  const Vec2 n{p.x * inverse, -p.y * inverse};
  if (!(n.x * n.x + n.y * n.y <= max_radius_ * max_radius_)) return std::nullopt;
  // Columns of the rotation are the camera's axes in the world.
  const Mat3& axes = pose_.linear;
  const Vec3 dx = parallel ? axes.x : (axes.x + axes.z * n.x) * inverse;
  const Vec3 dy = parallel ? -axes.y : (axes.z * n.y - axes.y) * inverse;
  Projection out;
  out.depth = depth;
  if (!distorted_) {
    out.u = camera_.cx + camera_.fx * n.x;
    out.v = camera_.cy + camera_.fy * n.y;
    out.du = dx * camera_.fx;
    out.dv = dy * camera_.fy;
    return out;
  }
  const Distorted d = Distort(camera_.distortion, n);
  out.u = camera_.cx + camera_.fx * d.value.x;
  out.v = camera_.cy + camera_.fy * d.value.y;
  out.du = (dx * d.xx + dy * d.xy) * camera_.fx;
  out.dv = (dx * d.xy + dy * d.yy) * camera_.fy;
  return out;
}

Vec2 CameraModel::PixelOf(const Vec2& normalized) const {
  const Vec2 d = Distort(camera_.distortion, normalized).value;
  return {camera_.cx + camera_.fx * d.x, camera_.cy + camera_.fy * d.y};
}

Camera ScaledCamera(const Camera& camera, int width, int height) {
  Camera out = camera;
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

Camera CroppedCamera(const Camera& camera, int x0, int y0, int width, int height) {
  Camera out = camera;
  out.width = width;
  out.height = height;
  out.cx -= x0;
  out.cy -= y0;
  const double share = out.SquaredHalfDiagonal() / camera.SquaredHalfDiagonal();
  out.vignetting.v1 *= share;
  out.vignetting.v2 *= share * share;
  out.vignetting.v3 *= share * share * share;
  return out;
}

}  // namespace pathfit::renderer
