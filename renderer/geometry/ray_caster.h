#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/geometry/mesh.h"
#include "renderer/geometry/ray.h"
#include "renderer/geometry/triangle_kernel.h"

namespace pathfit::renderer {

/// Ray queries against triangle meshes: the only door to Embree, whose float hits are refined in
/// double on the reported triangle. Geometry is stored relative to its centre, so that float
/// precision follows the object's size.
class RayCaster {
 public:
  RayCaster();
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  /// (Re)builds for meshes in the world frame. Embree errors become SceneError.
  void Build(const std::vector<const Mesh*>& meshes);

  [[nodiscard]] std::optional<Hit> Intersect(const Ray& ray) const;
  /// First hit at least `min_distance` away that is on none of `ignored` and, unless there are none
  /// of them, in its triangle to double precision.
  [[nodiscard]] std::optional<Hit> IntersectIgnoring(const Ray& ray,
                                                     double min_distance,
                                                     std::span<const TriangleId> ignored) const;
  /// Whether anything lies within `max_distance` (infinity allowed).
  [[nodiscard]] bool Occluded(const Ray& ray, double max_distance) const;

  /// How near a surface point x with unit normal n has other surfaces before it: least distance to
  /// a triangle of the meshes with `wanted[mesh]`, over the sine of how steeply the triangle rises
  /// above the plane of x, at most `max_distance`. Triangles in or below that plane do not count.
  [[nodiscard]] double DistanceBefore(const Vec3& x,
                                      const Vec3& n,
                                      const std::vector<bool>& wanted,
                                      double max_distance) const {
    return DistanceBefore(x, n, wanted, max_distance, max_distance);
  }
  /// Looks only for triangles within `radius`.
  [[nodiscard]] double DistanceBefore(const Vec3& x,
                                      const Vec3& n,
                                      const std::vector<bool>& wanted,
                                      double max_distance,
                                      double radius) const;
  /// Radius that is enough for DistanceBefore from all points within `slack` of x in the plane
  /// through x with normal n; 0 if these find nothing.
  [[nodiscard]] double SearchRadius(const Vec3& x,
                                    const Vec3& n,
                                    const std::vector<bool>& wanted,
                                    double max_distance,
                                    double slack) const;

  [[nodiscard]] const TriangleGeometry& Geometry(TriangleId id) const {
    return triangles_[static_cast<std::size_t>(first_triangle_[static_cast<std::size_t>(id.mesh)] +
                                               id.triangle)];
  }
  [[nodiscard]] std::size_t NumTriangles(int mesh) const {
    const auto m = static_cast<std::size_t>(mesh);
    const std::size_t end = m + 1 < first_triangle_.size()
                                ? static_cast<std::size_t>(first_triangle_[m + 1])
                                : triangles_.size();
    return end - static_cast<std::size_t>(first_triangle_[m]);
  }
  /// How far beside a surface a ray starts so that it does not meet the surface again, metres:
  /// kRayOffset times the extent.
  [[nodiscard]] double Offset() const { return offset_; }
  /// Half the diagonal of the bounding box, metres.
  [[nodiscard]] double Extent() const { return extent_; }
  [[nodiscard]] const Vec3& Center() const { return center_; }

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
  std::vector<std::int64_t> first_triangle_;
  std::vector<TriangleGeometry> triangles_;
  Vec3 center_;
  double extent_ = 0.0;
  double offset_ = 0.0;
};

/// Version of the Embree headers.
std::string EmbreeVersion();

/// Offset of secondary rays relative to the scene's extent: well above float rounding (6e-8) of
/// Embree's geometry.
inline constexpr double kRayOffset = 4e-6;
/// A shadow ray ends this share of its length before its end point.
inline constexpr double kShadowShortening = 1e-5;

}  // namespace pathfit::renderer
