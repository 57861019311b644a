#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "renderer/geometry/ray_caster.h"
#include "renderer/geometry/triangle_tree.h"
#include "renderer/path/surface_point.h"

namespace pathfit::renderer {

/// How near points of one mesh are to concave corners of the same mesh. Many samples see the same
/// triangle of a fine mesh: how far to look is found once for each. Thread-safe.
class OwnCorners {
 public:
  /// `caster` must outlive the result.
  OwnCorners(const RayCaster& caster, int mesh, std::size_t num_meshes, double reach);

  /// RayCaster::Nearness within the point's own mesh, before the surface (`side` 1) or behind it
  /// (-1).
  [[nodiscard]] double NearnessAt(const SurfacePoint& p, double side) const;

 private:
  const RayCaster& caster_;
  const int mesh_;
  std::vector<double> only_;
  double reach_;
  // RayCaster::SearchRadius of front and back of each triangle; negative: not yet known.
  std::unique_ptr<std::atomic<float>[]> radius_;
  // Of the mesh, made when a radius is asked for first.
  mutable std::once_flag tree_made_;
  mutable std::optional<TriangleTree> tree_;
};

}  // namespace pathfit::renderer
