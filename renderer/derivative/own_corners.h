#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "renderer/geometry/ray_caster.h"
#include "renderer/path/surface_point.h"

namespace pathfit::renderer {

/// How near points of one mesh are to concave corners of the same mesh. A fine mesh is asked once
/// per triangle how far it is worth looking, for many samples see the same triangle. Thread-safe.
class OwnCorners {
 public:
  /// `caster` must outlive the result; nothing is found beyond `reach`.
  OwnCorners(const RayCaster& caster, int mesh, std::size_t num_meshes, double reach);

  /// RayCaster::DistanceBefore within the point's own mesh, before the surface (`side` 1) or behind
  /// it (-1); infinity if nothing is found. Depends on the point alone.
  [[nodiscard]] double DistanceAt(const SurfacePoint& p, double side) const;

 private:
  const RayCaster& caster_;
  std::vector<bool> only_;
  double reach_;
  // Of the centres, front and back of each triangle; negative: not yet known.
  std::unique_ptr<std::atomic<float>[]> of_centre_;
};

}  // namespace pathfit::renderer
