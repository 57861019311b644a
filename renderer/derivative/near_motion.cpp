#include "renderer/derivative/near_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/geometry/near_corner.h"

namespace pathfit::renderer {

NearMotion::NearMotion(const World& world,
                       const LightSet& lights,
                       const ActiveParameters& active,
                       const RenderOptions& options)
    : world_(world),
      caster_(world.caster()),
      camera_moves_(active.camera.Any()),
      image_form_(options.form == DerivativeForm::kImage) {
  any_ = active.any_mesh_moves || (camera_moves_ && image_form_);
  const std::size_t count = active.meshes.size();
  for (std::size_t m = 0; m < count; ++m) {
    const int mesh = static_cast<int>(m);
    const bool moves = active.meshes[m].moves;
    const double size = kLarge * caster_.Bounds(mesh).HalfDiagonal();
    const double reach = kReach * std::min(caster_.Extent(), size);
    least_reach_ = std::min(least_reach_, reach);
    const bool shines = lights.AreaLightOf(mesh) != nullptr;
    if (shines) {
      shining_.push_back(mesh);
    }
    reach_.of_all.push_back(reach);
    reach_.of_moving.push_back(moves ? reach : 0.0);
    reach_of_shining_.of_all.push_back(shines ? reach : 0.0);
    reach_of_shining_.of_moving.push_back(shines && moves ? reach : 0.0);
    const bool slides = image_form_ && (camera_moves_ || moves);
    const bool meets_itself = options.max_bounces > 1 || (shines && options.max_bounces > 0);
    meets_own_corners_.push_back(slides && options.terms.Has(DerivativeTerm::kInterior) &&
                                 meets_itself);
  }
}

bool NearMotion::MayReachLight(const SurfacePoint& p) const {
  const double own = reach_.of_all[static_cast<std::size_t>(p.id.mesh)];
  return std::any_of(shining_.begin(), shining_.end(), [&](int mesh) {
    return caster_.Bounds(mesh).Distance(p.x) <
           std::min(own, reach_.of_all[static_cast<std::size_t>(mesh)]);
  });
}

double NearMotion::NearnessOfMotion(
    const SurfacePoint& p, bool slides, bool is_last, double most, NearFacts& facts) const {
  if (is_last && !MayReachLight(p)) {
    return most;
  }
  const auto mesh = static_cast<std::size_t>(p.id.mesh);
  slides = slides && meets_own_corners_[mesh];
  const Reaches& reach = is_last ? reach_of_shining_ : reach_;
  const bool meets_all = slides || reach_.of_moving[mesh] > 0.0;
  const RayCaster::Reach against{
      meets_all ? reach.of_all : reach.of_moving, reach_.of_all[mesh], p.id.mesh};
  double nearness = most;
  for (const double side : {1.0, -1.0}) {
    if (side < 0.0 && !IsTransmissive(p.material->bsdf)) {
      break;
    }
    if (slides) {
      nearness = world_.own_corners(p.id.mesh).Nearness(
          {p.x, p.ng * side, p.offset}, reach_.of_all[mesh], nearness, &facts);
    }
    nearness = caster_.Nearness(p.x, p.ng * side, against, nearness, &facts);
  }
  return nearness;
}

NearMotion::Split NearMotion::FirstSplit(const PathRecord& path,
                                         const PathContext& context,
                                         int first,
                                         double share) const {
  if (!any_) {
    return {};
  }
  // The last reflection only looks for light.
  const auto last = static_cast<std::size_t>(context.max_bounces) -
                    (context.lights.areas.empty() && context.max_bounces > 0 ? 1 : 0);
  bool visible = first == 0;  // next to the camera, mirrors and glass left aside
  Split split;
  for (auto k = static_cast<std::size_t>(first); k < std::min(last, path.vertices.size()); ++k) {
    const PathRecord::Vertex& v = path.vertices[k];
    if (IsDelta(v.p.material->bsdf) || !v.p.Reflects()) {
      continue;
    }
    // The last reflection meets surfaces that shine only.
    const bool is_last = static_cast<int>(k) + 1 == context.max_bounces;
    const bool meets_itself = !is_last || context.lights.AreaLightOf(v.p.id.mesh) != nullptr;
    const double missed = kMissed * v.p.offset;
    const double least = std::max(kTouch, missed / least_reach_);
    const double most = std::min(1.0, std::max(share, kStandIn * least));
    NearFacts facts;
    const double nearness =
        NearnessOfMotion(v.p, visible && image_form_ && meets_itself, is_last, most, facts);
    visible = false;
    split.vertex = static_cast<int>(k);
    if (facts.meets) {
      const double touch = std::max(kTouch, missed / facts.reach);
      if (nearness < touch) {
        split.touches = true;
        return split;
      }
      if (nearness < kStandIn * touch && k < std::numeric_limits<VertexBits>::digits) {
        split.stand_ins |= VertexBits{1} << k;
      }
    }
    if (nearness < share) {
      split.count = 2 * static_cast<int>(std::ceil(0.5 * share / std::max(kTouch, nearness)));
      return split;
    }
  }
  return split;
}

}  // namespace pathfit::renderer
