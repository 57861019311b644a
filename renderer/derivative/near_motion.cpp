#include "renderer/derivative/near_motion.h"

#include <algorithm>
#include <cmath>

namespace pathfit::renderer {

NearMotion::NearMotion(const RayCaster& caster,
                       const ActiveParameters& active,
                       const RenderOptions& options)
    : caster_(caster),
      camera_moves_(active.camera.Any()),
      image_form_(options.form == DerivativeForm::kImage) {
  any_ = active.any_mesh_moves || (camera_moves_ && image_form_);
  const std::size_t count = active.meshes.size();
  for (const auto& mesh : active.meshes) {
    moving_.push_back(mesh.moves);
  }
  own_corners_.resize(count);
  all_but_.resize(count);
  for (std::size_t m = 0; m < count; ++m) {
    const bool slides = image_form_ && (camera_moves_ || moving_[m]);
    if (slides || moving_[m]) {
      all_but_[m].assign(count, true);
      all_but_[m][m] = false;
    }
    if (slides && options.terms.interior && options.max_bounces > 0) {
      own_corners_[m] = std::make_unique<OwnCorners>(
          caster, static_cast<int>(m), count, kReach * caster.Extent());
    }
  }
}

double NearMotion::DistanceToMotion(const SurfacePoint& p, bool slides, double reach) const {
  const auto mesh = static_cast<std::size_t>(p.id.mesh);
  slides = slides && own_corners_[mesh] != nullptr;
  const std::vector<bool>& against = slides || moving_[mesh] ? all_but_[mesh] : moving_;
  double distance = reach;
  for (const double side : {1.0, -1.0}) {
    if (side < 0.0 && !IsTransmissive(p.material->bsdf)) {
      break;
    }
    if (slides) {
      distance = std::min(distance, own_corners_[mesh]->DistanceAt(p, side));
    }
    distance = caster_.DistanceBefore(p.x, p.ng * side, against, distance);
  }
  return distance;
}

NearMotion::Split NearMotion::FirstSplit(const PathRecord& path,
                                         const PathContext& context,
                                         int first,
                                         double share) const {
  if (!any_) {
    return {};
  }
  const double reach = kReach * caster_.Extent() * share;
  const double touch = kTouch * caster_.Offset();
  // The last reflection only looks for light.
  const auto last = static_cast<std::size_t>(context.max_bounces) -
                    (context.lights.areas.empty() && context.max_bounces > 0 ? 1 : 0);
  bool visible = first == 0;  // next to the camera, mirrors and glass left aside
  for (auto k = static_cast<std::size_t>(first); k < std::min(last, path.vertices.size()); ++k) {
    const PathRecord::Vertex& v = path.vertices[k];
    if (IsDelta(v.p.material->bsdf) || !v.p.Reflects()) {
      continue;
    }
    // The last reflection meets surfaces that shine only.
    const bool meets_itself = static_cast<int>(k) + 1 < context.max_bounces ||
                              context.lights.AreaLightOf(v.p.id.mesh) != nullptr;
    const double distance =
        DistanceToMotion(v.p, visible && image_form_ && meets_itself, std::max(reach, touch));
    visible = false;
    if (distance < touch) {
      return {static_cast<int>(k), 1, true};
    }
    if (distance < reach) {
      return {static_cast<int>(k), 2 * static_cast<int>(std::ceil(0.5 * reach / distance))};
    }
  }
  return {};
}

}  // namespace pathfit::renderer
