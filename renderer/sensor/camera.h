#pragma once

#include <array>
#include <optional>
#include <string>

#include "renderer/geometry/ray.h"
#include "renderer/math/transform.h"
#include "renderer/math/vector.h"
#include "renderer/sensor/lens_distortion.h"

namespace pathfit::renderer {

/// How a pixel weighs the image around its centre; separable, normalised to integrate to one per
/// pixel area (the values 1 / (pixel area) of a box of radius 0.5).
struct PixelFilter {
  enum class Shape { kBox, kTent, kGaussian };
  Shape shape = Shape::kBox;
  double radius = 0.5;  ///< half width in pixels, (0, 8]; box 0.5, tent usually 1, Gaussian 2
  double sigma = 0.5;   ///< Gaussian only, pixels, [1e-3, 1e3]; cut at `radius`, shifted to 0 there
  friend bool operator==(const PixelFilter&, const PixelFilter&) = default;
};

enum class ProjectionKind { kPerspective, kOrthographic };

/// Camera: pinhole with distortion, or parallel (orthographic: fx, fy are pixels per metre, no
/// distortion, rays start in the plane through the camera's centre). Pixel coordinates (u right,
/// v down) have their origin at the top-left image corner: the centre of the first pixel is
/// (0.5, 0.5). Camera frame: x right, y up, looking along -z.
struct Camera {
  std::string name;
  ProjectionKind projection = ProjectionKind::kPerspective;
  int width = 0, height = 0;                      ///< pixels
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  ///< pixels
  LensDistortion distortion;
  Transform world_from_camera;  ///< rigid, metres; before `rotation`
  /// Rotation vector in the world frame that turns the camera about its centre, after
  /// world_from_camera: what a fit of the orientation moves.
  Vec3 rotation{0.0, 0.0, 0.0};
  PixelFilter filter;
  double gain = 1.0;  ///< exposure: pixel value per unit radiance
};

/// world_from_camera with `rotation` applied: where the camera is.
Transform CameraPose(const Camera& camera);

/// Pixel coordinates of a world point and their derivative by it (rows: d u / d x, d v / d x).
struct Projection {
  double u = 0.0, v = 0.0;
  Vec3 du, dv;
  double depth = 0.0;  ///< distance along the viewing axis, metres
};

/// Ready-to-use form of a camera: inverse pose and the region where the distortion can be inverted.
class CameraModel {
 public:
  /// Throws SceneError for non-positive sizes or focal lengths, non-finite numbers, a pose that is
  /// not a rotation, a filter out of range, a distortion that folds inside the image (with the
  /// filter's reach beyond its border), or a distorted parallel camera.
  explicit CameraModel(const Camera& camera);

  [[nodiscard]] const Camera& camera() const { return camera_; }
  /// The camera's centre.
  [[nodiscard]] const Vec3& Origin() const { return pose_.translation; }
  /// world_from_camera with `rotation` applied: what everything else must use.
  [[nodiscard]] const Transform& Pose() const { return pose_; }
  [[nodiscard]] bool IsOrthographic() const {
    return camera_.projection == ProjectionKind::kOrthographic;
  }
  /// Unit ray through pixel coordinates.
  [[nodiscard]] Ray RayThrough(double u, double v) const;
  /// Empty behind the camera or outside the invertible field of view.
  [[nodiscard]] std::optional<Projection> Project(const Vec3& x_in_world) const;
  /// Ray from x to where it is seen from: the centre, or the plane of parallel rays; and the
  /// distance to there in metres, negative behind that plane.
  [[nodiscard]] Ray RayTo(const Vec3& x_in_world, double& distance) const;

  /// The numbers inside a camera: fx fy cx cy k1 k2 k3 p1 p2.
  static constexpr int kNumIntrinsics = 9;
  /// Derivative of the ray through fixed pixel coordinates by each of them, world frame.
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
  Transform pose_;
  Transform camera_from_world_;
  double max_radius_ = 0.0;
};

/// The same view at another resolution: intrinsics scale with width and height separately.
Camera ScaledCamera(const Camera& camera, int width, int height);
/// The part of the image with top-left pixel (x0, y0): only the principal point and size change.
Camera CroppedCamera(const Camera& camera, int x0, int y0, int width, int height);

}  // namespace pathfit::renderer
