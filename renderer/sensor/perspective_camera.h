#pragma once

#include <optional>
#include <string>

#include "renderer/geometry/ray.h"
#include "renderer/math/transform.h"
#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// Brown lens distortion on normalised image coordinates (x right, y down), OpenCV's convention:
/// x_d = x (1 + k1 r2 + k2 r2^2 + k3 r2^3) + 2 p1 x y + p2 (r2 + 2 x^2), and likewise y.
struct LensDistortion {
  double k1 = 0.0, k2 = 0.0, k3 = 0.0, p1 = 0.0, p2 = 0.0;
  [[nodiscard]] bool IsNone() const {
    return k1 == 0.0 && k2 == 0.0 && k3 == 0.0 && p1 == 0.0 && p2 == 0.0;
  }
  friend bool operator==(const LensDistortion&, const LensDistortion&) = default;
};

/// Pinhole camera with distortion. Pixel coordinates (u right, v down) have their origin at the
/// top-left image corner: the centre of the first pixel is (0.5, 0.5). Camera frame: x right, y up,
/// looking along -z.
struct PerspectiveCamera {
  std::string name;
  int width = 0, height = 0;                      ///< pixels
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  ///< pixels
  LensDistortion distortion;
  Transform world_from_camera;  ///< rigid, metres
  double gain = 1.0;            ///< exposure: pixel value per unit radiance
};

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
  /// not a rotation, or a distortion that folds inside the image.
  explicit CameraModel(const PerspectiveCamera& camera);

  [[nodiscard]] const PerspectiveCamera& camera() const { return camera_; }
  [[nodiscard]] const Vec3& Origin() const { return camera_.world_from_camera.translation; }
  /// Unit ray through pixel coordinates.
  [[nodiscard]] Ray RayThrough(double u, double v) const;
  /// Empty behind the camera or outside the invertible field of view.
  [[nodiscard]] std::optional<Projection> Project(const Vec3& x_in_world) const;
  /// Pixel coordinates of undistorted normalised coordinates (x right, y down) within MaxTangent.
  [[nodiscard]] Vec2 PixelOf(const Vec2& normalized) const;
  /// Largest tangent of the view angle that Project accepts.
  [[nodiscard]] double MaxTangent() const { return max_radius_; }

 private:
  /// Normalised undistorted coordinates (x right, y down) of pixel coordinates.
  [[nodiscard]] Vec2 Undistort(const Vec2& distorted) const;

  PerspectiveCamera camera_;
  Transform camera_from_world_;
  double max_radius_ = 0.0;
};

/// The same view at another resolution: intrinsics scale with width and height separately.
PerspectiveCamera ScaledCamera(const PerspectiveCamera& camera, int width, int height);
/// The part of the image with top-left pixel (x0, y0): only the principal point and size change.
PerspectiveCamera CroppedCamera(
    const PerspectiveCamera& camera, int x0, int y0, int width, int height);

}  // namespace pathfit::renderer
