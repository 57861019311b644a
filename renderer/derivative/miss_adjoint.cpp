#include "renderer/derivative/appearance_adjoint.h"
#include "renderer/derivative/path_adjoint.h"

namespace pathfit::renderer {

ColorGradient SkyGradient(const LightSet::Environment& environment,
                          const Vec3& direction,
                          const Rgb& weight) {
  const std::array<Vec3, 3> slope =
      EnvironmentGradient(*environment.light, environment.light_from_world * direction);
  ColorGradient d;
  for (int c = 0; c < 3; ++c) {
    d[c] = (environment.world_from_light * slope[static_cast<std::size_t>(c)]) * weight[c];
  }
  return d;
}

void AccumulateMissAdjoint(const AdjointContext& context,
                           const PixelSample& pixel,
                           DerivativeAccumulator& sum) {
  const LightSet::Environment& environment = *context.path.lights.environment;
  const Vec3& w = pixel.ray.direction;
  AppearanceAdjoint(context.path, context.active, sum)
      .Environment(environment, w, Rgb::Constant(pixel.weight));
  AccumulatorTarget target(sum);
  MotionAdjoint<ColorGradient, AccumulatorTarget> motion(
      *context.path.world, context.camera, context.active, target);
  const bool light_moves = motion.LightMoves(environment.emitter);
  if (!light_moves && !context.active.camera.Any()) {
    return;
  }
  if (context.form == DerivativeForm::kImage || context.camera.IsOrthographic()) {
    const ColorGradient d_w = SkyGradient(environment, w, Rgb::Constant(pixel.weight));
    motion.LightSpin(environment.emitter, -Cross(w, d_w));
    motion.CameraRay(pixel.ray, pixel.u, pixel.v, ColorGradient{}, d_w);
    return;
  }
  // The label is a direction that turns with the environment: the radiance stays, the pixel area
  // per solid angle (surface at unit distance that faces the sensor) and the filter change.
  const Rgb radiance = EnvironmentRadianceInWorld(environment, w);
  const Rgb value = radiance * pixel.weight;
  const Vec3 x = pixel.ray.origin + w;
  const CameraModel::PixelDensity density = context.camera.DensityAt(x, w);
  const auto projection = context.camera.Project(x);
  if (!projection) {
    return;
  }
  const Rgb d_u = radiance * pixel.slope_u;
  const Rgb d_v = radiance * pixel.slope_v;
  const ColorGradient d_w = Outer(density.d_x + density.d_n, value) + Outer(projection->du, d_u) +
                            Outer(projection->dv, d_v);
  motion.LightSpin(environment.emitter, Cross(w, d_w));
  motion.CameraMotion(ColorGradient{}, -Cross(w, d_w));
  std::array<Rgb, CameraModel::kNumIntrinsics> d{};
  const auto by = context.camera.PixelByIntrinsics(x);
  for (std::size_t i = 0; i < d.size(); ++i) {
    d[i] = value * density.d_intrinsics[i] + d_u * by[i].x + d_v * by[i].y;
  }
  motion.Intrinsics(d);
}

}  // namespace pathfit::renderer
