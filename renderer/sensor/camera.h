#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "renderer/geometry/ray.h"
#include "renderer/math/rgb.h"
#include "renderer/math/transform.h"
#include "renderer/math/vector.h"
#include "renderer/sensor/lens_distortion.h"
#include "renderer/sensor/vignetting.h"

namespace pathfit::renderer {

/// How a pixel weighs the image around its centre: the product of one function of the distance in u
/// and the same of that in v, normalised to integrate to one over the image plane in pixels. The
/// default is the pixel's own square.
struct PixelFilter {
  enum class Shape {
    kBox,      ///< constant within `radius`
    kTent,     ///< falls linearly to zero at `radius`
    kGaussian  ///< exp(-d^2 / (2 sigma^2)) less its value at `radius`
  };
  Shape shape = Shape::kBox;
  double radius = 0.5;  ///< half width in pixels, (0, 8]; box 0.5, tent usually 1, Gaussian 2
  double sigma = 0.5;   ///< of the Gaussian, pixels, [1e-3, 1e3]; unused by other shapes
  friend bool operator==(const PixelFilter&, const PixelFilter&) = default;
};

enum class ProjectionKind {
  kPerspective,  ///< pinhole with lens distortion; rays start at the centre
  kOrthographic  ///< parallel rays along the axis from the plane through the centre; no distortion
};

/// A camera as numbers, valid once CameraModel takes it.
///
/// Camera frame: x right, y up, looking along -z, metres. Pixel coordinates: u right, v down, the
/// origin at the top-left corner of the image, so that the centre of the first pixel is (0.5, 0.5)
/// and the image is [0, width] x [0, height]. A point (x, y, z) of the camera frame, z < 0, has the
/// normalised coordinates (x / -z, y / z), of parallel rays (x, -y), and with (a, b) the distorted
/// ones the pixel coordinates (fx a + cx, fy b + cy). OpenCV's camera matrix and distortion
/// coefficients are the same numbers, but for cx and cy, which count from the centre of the first
/// pixel there and are 0.5 less.
struct Camera {
  std::string name;  ///< for messages, and its parameters' names
  ProjectionKind projection = ProjectionKind::kPerspective;
  int width = 0, height = 0;    ///< pixels, > 0
  double fx = 0.0, fy = 0.0;    ///< focal lengths in pixels, of parallel rays pixels per metre; > 0
  double cx = 0.0, cy = 0.0;    ///< principal point, pixel coordinates; may lie outside the image
  LensDistortion distortion;    ///< none by default
  Transform world_from_camera;  ///< rotation and translation, metres; before `rotation`
  /// Rotation vector in the world frame that turns the camera about its centre, after
  /// world_from_camera: what a fit of the orientation moves.
  Vec3 rotation{0.0, 0.0, 0.0};
  PixelFilter filter;
  double gain = 1.0;             ///< exposure: pixel value per unit radiance, > 0
  double red = 1.0, blue = 1.0;  ///< white balance: factors of these channels beside gain, > 0
  Vignetting vignetting;         ///< none by default; a factor of at most e^20 either way
  /// Lights of the scene that are switched off while this camera takes its picture: indices into
  /// Scene::emitters, ascending. Empty: all shine.
  std::vector<int> lights_off;

  /// Pixel value per unit radiance of each channel, without vignetting.
  [[nodiscard]] Rgb ChannelGains() const { return {gain * red, gain, gain * blue}; }
  /// The same of one pixel.
  [[nodiscard]] Rgb PixelGains(int x, int y) const {
    return vignetting.IsNone() ? ChannelGains()
                               : ChannelGains() * vignetting.At(VignettingRadius2(x, y));
  }
  /// Squared distance of a pixel's centre from the principal point, both in focal lengths, over
  /// that of half the image's diagonal: of whole pictures at all resolutions alike.
  [[nodiscard]] double VignettingRadius2(int x, int y) const {
    const double a = (x + 0.5 - cx) / fx, b = (y + 0.5 - cy) / fy;
    return (a * a + b * b) / SquaredHalfDiagonal();
  }
  /// Of the image, in focal lengths.
  [[nodiscard]] double SquaredHalfDiagonal() const {
    const double a = width / fx, b = height / fy;
    return 0.25 * (a * a + b * b);
  }
  /// Pixel values are radiance again: no exposure, white balance or vignetting.
  void ForgetResponse() {
    gain = red = blue = 1.0;
    vignetting = {};
  }
};

/// Whether a light is among those of Camera::lights_off.
bool IsOff(const std::vector<int>& lights_off, int emitter);

/// Whether two pictures may be by the same lens: of one size, all that shapes their image alike.
bool HaveSameLens(const Camera& a, const Camera& b);

/// world_from_camera with `rotation` applied, about the camera's centre: where the camera is. The
/// camera need not be valid.
Transform CameraPose(const Camera& camera);

/// Pixel coordinates of a world point and their derivative by it.
struct Projection {
  double u = 0.0, v = 0.0;  ///< pixels; may lie outside the image
  Vec3 du, dv;              ///< gradients of u and v by the point, world frame, pixels per metre
  double depth = 0.0;       ///< distance along the viewing axis, metres
};

/// Ready-to-use form of a camera: inverse pose and the region where the distortion can be inverted.
class CameraModel {
 public:
  /// Throws SceneError for non-positive sizes or focal lengths, non-finite numbers, a pose that is
  /// not a rotation, a filter out of range, a distortion that folds inside the image (with the
  /// filter's reach beyond its border), vignetting out of range, or a distorted parallel camera.
  explicit CameraModel(const Camera& camera);

  /// The camera as it was given.
  [[nodiscard]] const Camera& camera() const { return camera_; }
  /// The camera's centre, world frame.
  [[nodiscard]] const Vec3& Origin() const { return pose_.translation; }
  /// world_from_camera with `rotation` applied: what everything else must use.
  [[nodiscard]] const Transform& Pose() const { return pose_; }
  [[nodiscard]] bool IsOrthographic() const {
    return camera_.projection == ProjectionKind::kOrthographic;
  }
  /// Ray of the world, with unit direction away from the camera, that is seen at pixel coordinates:
  /// from the centre, or from the plane of parallel rays. They may lie outside the image as far as
  /// the filter of a border pixel reaches.
  [[nodiscard]] Ray RayThrough(double u, double v) const {
    const Vec2 distorted = {(u - camera_.cx) / camera_.fx, (v - camera_.cy) / camera_.fy};
    const Vec2 x = distorted_ ? Undistort(distorted) : distorted;
    if (IsOrthographic()) {
      return {pose_.Point({x.x, -x.y, 0.0}), -pose_.linear.z};
    }
    const Vec3 direction = pose_.Direction({x.x, -x.y, -1.0});
    return {Origin(), direction * (1.0 / Norm(direction))};
  }
  /// Where a world point is seen; whether something hides it does not matter. Empty unless the
  /// point is before the camera and within MaxTangent, that is inside the field of view where the
  /// distortion can be inverted; RayThrough(u, v) of the result leads through the point.
  [[nodiscard]] std::optional<Projection> Project(const Vec3& x_in_world) const;
  /// Ray from x to where it is seen from: the centre, or the plane of parallel rays; and the
  /// distance to there in metres, negative behind that plane.
  [[nodiscard]] Ray RayTo(const Vec3& x_in_world, double& distance) const;

  /// The numbers inside a camera: fx fy cx cy k1 k2 k3 p1 p2.
  static constexpr int kNumIntrinsics = 9;
  /// Derivatives of the ray through fixed pixel coordinates by each of them, in that order, world
  /// frame. The direction stays unit: its derivatives are at right angles to it.
  struct RayIntrinsics {
    std::array<Vec3, kNumIntrinsics> origin{}, direction{};
  };
  [[nodiscard]] RayIntrinsics RayByIntrinsics(double u, double v) const;
  /// Derivative of Project(x)'s pixel coordinates by each of them, at fixed x; zero where Project
  /// is empty.
  [[nodiscard]] std::array<Vec2, kNumIntrinsics> PixelByIntrinsics(const Vec3& x_in_world) const;
  /// Pixel area per surface area at x with unit normal n, |n . (du x dv)|, and the derivatives of
  /// its logarithm by x and n (as free vectors) and the intrinsics. All zero where Project is empty
  /// and for a surface seen edge-on. [path_space 1.1: f^2 |n.y| / y_z^3 for a pinhole]
  struct PixelDensity {
    double value = 0.0;
    Vec3 d_x, d_n;
    std::array<double, kNumIntrinsics> d_intrinsics{};
  };
  [[nodiscard]] PixelDensity DensityAt(const Vec3& x_in_world, const Vec3& n) const;

  /// Pixel coordinates of undistorted normalised coordinates (x right, y down) within MaxTangent:
  /// position over depth in the camera frame, of parallel rays the position itself, in metres.
  [[nodiscard]] Vec2 PixelOf(const Vec2& normalized) const;
  /// Largest distance of normalised coordinates from the axis that Project accepts: the tangent of
  /// a view angle, or metres for parallel rays. All that any pixel's filter sees is nearer.
  [[nodiscard]] double MaxTangent() const { return max_radius_; }

 private:
  /// Normalised undistorted coordinates (x right, y down) of pixel coordinates.
  [[nodiscard]] Vec2 Undistort(const Vec2& distorted) const;
  /// Normalised coordinates of a point that projects.
  [[nodiscard]] std::optional<Vec2> NormalizedOf(const Vec3& x_in_world) const;
  /// Largest distance from the axis of all that the filters see.
  [[nodiscard]] double FieldRadius() const;

  Camera camera_;
  bool distorted_ = false;
  NearInverse near_inverse_;  ///< where Newton's method begins
  Transform pose_;
  Transform camera_from_world_;
  double max_radius_ = 0.0;
};

/// The same view at another resolution: fx and cx scale with the width, fy and cy with the height.
/// The filter keeps its size in pixels. Sizes must be positive.
Camera ScaledCamera(const Camera& camera, int width, int height);
/// The part of the image of the given size whose top-left pixel is pixel (x0, y0) of `camera`: only
/// the principal point and the size change, and the numbers of the vignetting, which goes by that.
/// The part may reach beyond the image.
Camera CroppedCamera(const Camera& camera, int x0, int y0, int width, int height);

}  // namespace pathfit::renderer
