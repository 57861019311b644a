#include "renderer/boundary/visible_point.h"

namespace pathfit::renderer {

bool IsInImageForm(const BoundaryContext& context, const std::optional<Hit>& hit) {
  return context.options.form == DerivativeForm::kImage ||
         (!hit && context.camera.IsOrthographic());
}

bool SkyMoves(const BoundaryContext& context) {
  const auto& environment = context.path.lights.environment;
  return environment && context.active.lights[static_cast<std::size_t>(environment->emitter)].moves;
}

void AddMotionOfVisiblePoint(const BoundaryContext& context,
                             const std::optional<Hit>& hit,
                             const Ray& ray,
                             const Vec2& m,
                             MotionRow& row) {
  const RayCaster& caster = context.path.world->caster();
  const Vec3 x = hit ? caster.Geometry(hit->id).Point(hit->b1, hit->b2)
                     : context.camera.Origin() + ray.direction;
  const auto projection = context.camera.Project(x);
  if (!projection) {
    return;
  }
  const Vec3 d_x = projection->du * m.x + projection->dv * m.y;
  MotionAdjoint<Vec3, MotionRow> motion(*context.path.world, context.camera, context.active, row);
  if (hit) {
    motion.MaterialPoint(hit->id, hit->b1, hit->b2, d_x);
    motion.PixelOfFixedPoint(x, *projection, m.x, m.y);
    return;
  }
  motion.PixelOfFixedDirection(ray.direction, *projection, m.x, m.y);
  const auto& environment = context.path.lights.environment;
  if (environment && motion.LightMoves(environment->emitter)) {
    motion.LightSpin(environment->emitter, Cross(ray.direction, d_x));
  }
}

}  // namespace pathfit::renderer
