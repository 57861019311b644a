#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/geometry/mesh.h"
#include "renderer/geometry/ray.h"
#include "renderer/geometry/triangle_kernel.h"
#include "renderer/math/box.h"

namespace pathfit::renderer {

struct NearFacts;  // near_corner.h

/// What rounding and offsets of rays are measured from.
struct RayFrame {
  Vec3 center;                  ///< see RayCaster::Center()
  double least_distance = 0.0;  ///< distances from the centre count as at least this, metres
};

/// Ray queries against triangle meshes: the only door to Embree, whose float hits are refined in
/// double on the reported triangle. Geometry is stored relative to Center(), so that its rounding
/// is a share of the distance from there. Triangles that are large for their distance from it are
/// stored in pieces: else all of a large triangle would be as inexact as its corners.
class RayCaster {
 public:
  RayCaster();
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  /// (Re)builds for meshes in the world frame. Center() is chosen without those with aside[mesh],
  /// unless there are no others; empty: none is aside. With `frame`, that of another caster, rays
  /// are rounded and offset as by that one. Embree errors become SceneError.
  void Build(const std::vector<const Mesh*>& meshes,
             const std::vector<bool>& aside = {},
             const std::optional<RayFrame>& frame = {});

  [[nodiscard]] std::optional<Hit> Intersect(const Ray& ray) const;
  /// First hit at least `min_distance` away that is on none of `ignored` and, unless there are none
  /// of them, in its triangle to double precision.
  [[nodiscard]] std::optional<Hit> IntersectIgnoring(const Ray& ray,
                                                     double min_distance,
                                                     std::span<const TriangleId> ignored) const;
  /// Whether anything lies within `max_distance` (infinity allowed).
  [[nodiscard]] bool Occluded(const Ray& ray, double max_distance) const;

  /// The same of several rays, bit for bit; `coherent`: from one place in almost one direction.
  void Intersect(std::span<const Ray> rays,
                 bool coherent,
                 std::span<std::optional<Hit>> hits) const {
    if (rays.size() >= kLeastTogether) {
      return IntersectTogether(rays, coherent, hits);
    }
    for (std::size_t i = 0; i < rays.size(); ++i) {
      hits[i] = Intersect(rays[i]);
    }
  }
  void Occluded(std::span<const Segment> segments, std::span<bool> occluded) const {
    if (segments.size() >= kLeastTogether) {
      return OccludedTogether(segments, occluded);
    }
    for (std::size_t i = 0; i < segments.size(); ++i) {
      occluded[i] = Occluded(segments[i].ray, segments[i].length);
    }
  }

  /// Up to which distance the triangles of each mesh count.
  struct Reach {
    std::span<const double> of_mesh;  ///< 0: not at all
    double most = std::numeric_limits<double>::infinity();
    int except = -1;  ///< a mesh that does not count
    [[nodiscard]] double Of(int mesh) const {
      return mesh == except ? 0.0 : std::min(most, of_mesh[static_cast<std::size_t>(mesh)]);
    }
  };
  /// How near a surface point x with unit normal n has other surfaces before it: least distance to
  /// a triangle, over the sine of how steeply the triangle rises above the plane of x, over the
  /// reach of its mesh; at most `most`, at most 1; 0 where rays no longer meet the triangle as they
  /// should. Triangles in or below that plane do not count.
  [[nodiscard]] double Nearness(const Vec3& x,
                                const Vec3& n,
                                const Reach& reach,
                                double most = 1.0,
                                NearFacts* facts = nullptr) const;

  /// The triangle of which Embree's primitive is all or a piece.
  [[nodiscard]] TriangleId TriangleOf(unsigned geometry, unsigned primitive) const {
    const std::vector<std::int32_t>& pieces = pieces_[geometry];
    return {static_cast<std::int32_t>(geometry),
            pieces.empty() ? static_cast<std::int32_t>(primitive) : pieces[primitive]};
  }
  [[nodiscard]] const TriangleGeometry& Geometry(TriangleId id) const {
    return triangles_[static_cast<std::size_t>(first_triangle_[static_cast<std::size_t>(id.mesh)] +
                                               id.triangle)];
  }
  /// All of a mesh.
  [[nodiscard]] std::span<const TriangleGeometry> TrianglesOf(int mesh) const {
    return std::span(triangles_)
        .subspan(static_cast<std::size_t>(first_triangle_[static_cast<std::size_t>(mesh)]),
                 NumTriangles(mesh));
  }
  [[nodiscard]] std::size_t NumTriangles(int mesh) const {
    const auto m = static_cast<std::size_t>(mesh);
    const std::size_t end = m + 1 < first_triangle_.size()
                                ? static_cast<std::size_t>(first_triangle_[m + 1])
                                : triangles_.size();
    return end - static_cast<std::size_t>(first_triangle_[m]);
  }
  /// How far beside a surface at x a ray starts so that it does not meet the surface again, metres:
  /// kRayOffset times the distance from Center(). All that depends on what rays can tell apart near
  /// a point is a multiple of it.
  [[nodiscard]] double Offset(const Vec3& x) const {
    return kRayOffset * std::max(Norm(x - frame_.center), frame_.least_distance);
  }
  [[nodiscard]] const Box& Bounds(int mesh) const {
    return bounds_[static_cast<std::size_t>(mesh)];
  }
  /// Half the diagonal of the bounding box, metres.
  [[nodiscard]] double Extent() const { return extent_; }
  /// Near the middle of a mesh, chosen so that every mesh lies near for its size; it moves in steps
  /// of about that mesh's size.
  [[nodiscard]] const Vec3& Center() const { return frame_.center; }
  [[nodiscard]] const RayFrame& frame() const { return frame_; }

  /// Well above the float rounding (6e-8) of Embree's geometry and of its tests.
  static constexpr double kRayOffset = 4e-6;

 private:
  // Fewer rays are faster alone.
  static constexpr std::size_t kLeastTogether = 4;

  void IntersectTogether(std::span<const Ray> rays,
                         bool coherent,
                         std::span<std::optional<Hit>> hits) const;
  void OccludedTogether(std::span<const Segment> segments, std::span<bool> occluded) const;
  [[nodiscard]] Hit Refined(unsigned geometry, unsigned primitive, const Ray& ray) const {
    const TriangleId id = TriangleOf(geometry, primitive);
    const PlaneHit hit = IntersectPlane(Geometry(id), ray.origin, ray.direction);
    return {id, hit.b1, hit.b2, hit.distance};
  }

  struct Handles;
  std::unique_ptr<Handles> handles_;
  std::vector<std::int64_t> first_triangle_;
  std::vector<TriangleGeometry> triangles_;
  std::vector<Box> bounds_;
  std::vector<std::vector<std::int32_t>> pieces_;  // by mesh: whose piece it is; empty: none is cut
  RayFrame frame_;
  double extent_ = 0.0;
};

/// Version of the Embree headers.
std::string EmbreeVersion();

/// A shadow ray ends this share of its length before its end point.
inline constexpr double kShadowShortening = 1e-5;

}  // namespace pathfit::renderer
