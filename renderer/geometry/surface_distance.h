#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "renderer/geometry/mesh.h"

namespace pathfit::renderer {

/// A point of a mesh by its triangle: x = (1 - b1 - b2) p0 + b1 p1 + b2 p2.
struct MeshPoint {
  std::int32_t triangle = -1;
  double b1 = 0.0, b2 = 0.0;
  Vec3 x;
};

/// `count` > 0 points of a mesh with area, the same number from each piece of the same area: only
/// the place within a piece is random, and always the same.
std::vector<MeshPoint> UniformPoints(const Mesh& mesh, int count);

/// Finds the nearest point of a surface, of all points of its triangles (not of samples, which
/// would add half their spacing). Constant members may be called from several threads at once.
class NearestSurface {
 public:
  /// Of a mesh with triangles, which must outlive it.
  explicit NearestSurface(const Mesh& mesh);
  NearestSurface(const NearestSurface&) = delete;
  NearestSurface& operator=(const NearestSurface&) = delete;
  ~NearestSurface();

  [[nodiscard]] MeshPoint Nearest(const Vec3& x) const;

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

/// How far the points of one surface are from another.
struct SurfaceGap {
  double mean = 0.0, rms = 0.0, most = 0.0;  ///< metres
  double mean_angle = 0.0;                   ///< between the normals there, radians
};
/// Of points of `from`, of which there are some; `to` has triangles.
SurfaceGap GapBetween(const Mesh& from, const std::vector<MeshPoint>& points, const Mesh& to);

}  // namespace pathfit::renderer
