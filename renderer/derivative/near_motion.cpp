#include "renderer/derivative/near_motion.h"

#include <algorithm>
#include <cmath>

namespace pathfit::renderer {

NearMotion::NearMotion(const RayCaster& caster, const ActiveParameters& active)
    : caster_(caster), any_(active.any_mesh_moves) {
  const std::size_t count = active.meshes.size();
  for (const auto& mesh : active.meshes) {
    moving_.push_back(mesh.moves);
  }
  all_but_.resize(count);
  for (std::size_t m = 0; m < count; ++m) {
    if (moving_[m]) {
      all_but_[m].assign(count, true);
      all_but_[m][m] = false;
    }
  }
}

NearMotion::Split NearMotion::FirstSplit(const PathRecorder& path,
                                         const PathContext& context,
                                         int first,
                                         double share) const {
  if (!any_) {
    return {};
  }
  const double reach = kReach * caster_.Extent() * share;
  // The last reflection only looks for light.
  const auto last = static_cast<std::size_t>(context.max_bounces) -
                    (context.lights.areas.empty() && context.max_bounces > 0 ? 1 : 0);
  for (auto k = static_cast<std::size_t>(first); k < std::min(last, path.vertices.size()); ++k) {
    const PathRecorder::Vertex& v = path.vertices[k];
    if (IsDelta(v.p.material->bsdf) || !v.p.Reflects()) {
      continue;
    }
    const auto mesh = static_cast<std::size_t>(v.p.id.mesh);
    const double distance =
        caster_.DistanceTo(v.p.x, moving_[mesh] ? all_but_[mesh] : moving_, reach);
    if (distance < kTouch * kRayOffset * caster_.Extent()) {
      return {static_cast<int>(k), 1, true};
    }
    if (distance < reach) {
      return {static_cast<int>(k), static_cast<int>(std::ceil(reach / distance))};
    }
  }
  return {};
}

}  // namespace pathfit::renderer
