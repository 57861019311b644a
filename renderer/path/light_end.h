#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <variant>

#include "renderer/math/warp.h"
#include "renderer/path/surface_point.h"
#include "renderer/scene/light_set.h"

namespace pathfit::renderer {

/// A point that stays at its place on a mesh.
struct MaterialPoint {
  TriangleId id;
  double b1 = 0.0, b2 = 0.0;
};

/// Where light comes from: a point of a mesh (that shines, or of a boundary segment that reflects),
/// a point light, spot or projector, or the direction of a light at infinity. Pointers are into the
/// LightSet of the path's context.
using LightEnd = std::variant<MaterialPoint,
                              const LightSet::PointLight*,
                              const LightSet::Directional*,
                              const LightSet::Environment*>;

/// Joins functions into one visitor of a variant.
template <class... F>
struct Visitor : F... {
  using F::operator()...;
};
template <class... F>
Visitor(F...) -> Visitor<F...>;

/// A light as one point of the scene sees it.
struct SeenLight {
  LightEnd end;
  Vec3 w{};  ///< unit, from the point to the light
  double distance = std::numeric_limits<double>::infinity();
  /// Radiance, intensity or irradiance towards the point. An estimate of what the point receives
  /// per unit of cosine is radiance / pdf.
  Rgb radiance{};
  double pdf = 1.0;  ///< of w per steradian; point lights: the squared distance; directional: 1
  bool has_extent = false;  ///< area lights and environments: BSDF samples find them, too
  bool is_visible = false;  ///< nothing lies between
};

/// EnvironmentUv of a world direction; not set for a constant environment, which needs none.
inline Vec2 UvTowards(const LightSet::Environment& environment, const Vec3& w) {
  return environment.light->texels.size() > 1 ? EnvironmentUv(environment.light_from_world * w)
                                              : Vec2{};
}
inline Rgb EnvironmentRadianceInWorld(const LightSet::Environment& environment,
                                      const Vec3& direction) {
  return EnvironmentRadianceAt(*environment.light, UvTowards(environment, direction));
}

/// For receivers that light may reach from everywhere.
struct AcceptsAll {
  bool operator()(const Vec3& /*w*/) const { return true; }
};

/// A point of an area light whose density per square metre is `pdf`; empty where it is edge on or
/// shows a side that does not shine. Here and below: empty, too, unless accepts(w), which is asked
/// before anything costly.
template <class Accepts = AcceptsAll>
[[gnu::always_inline]] inline std::optional<SeenLight> SeeAreaPoint(const World& world,
                                                                    const LightSet& lights,
                                                                    const MaterialPoint& y,
                                                                    double pdf,
                                                                    const Vec3& x,
                                                                    Accepts accepts = {}) {
  const TriangleGeometry& triangle = world.caster().Geometry(y.id);
  const Vec3 to_light = triangle.Point(y.b1, y.b2) - x;
  const double distance2 = SquaredNorm(to_light);
  // Made where it is returned: a copy would wait for the parts it has just been written in.
  std::optional<SeenLight> result;
  SeenLight& light = result.emplace();
  light.end = y;
  light.distance = std::sqrt(distance2);
  light.w = to_light * (1.0 / light.distance);
  const double cos_light = -Dot(triangle.n, light.w);
  const LightSet::AreaLight& area = *lights.AreaLightOf(y.id.mesh);
  if (!(distance2 > 0.0) || cos_light == 0.0 || (cos_light < 0.0 && !area.light->two_sided) ||
      !accepts(light.w)) {
    result.reset();
    return result;
  }
  light.radiance = AreaRadiance(area, y.id.triangle, y.b1, y.b2, cos_light > 0.0 ? 1.0 : -1.0);
  light.pdf = pdf * distance2 / std::abs(cos_light);
  light.has_extent = true;
  return result;
}

/// What a surface point finds of area lights at a chosen point or in a chosen direction.
template <class Accepts>
[[gnu::always_inline]] inline std::optional<SeenLight> SeeArea(const World& world,
                                                               const LightSet& lights,
                                                               const AreaChoice& choice,
                                                               const SurfacePoint& p,
                                                               Accepts accepts) {
  if (choice.point.pdf > 0.0) {
    const auto& [id, b1, b2, pdf] = choice.point;
    return SeeAreaPoint(world, lights, {id, b1, b2}, pdf, p.x, accepts);
  }
  if (!(choice.pdf > 0.0) || !accepts(choice.direction)) {
    return std::nullopt;
  }
  const RayCaster& caster = world.caster();
  const auto hit = caster.Intersect({RayStart(p, choice.direction), choice.direction});
  if (!hit || hit->id.mesh != choice.mesh) {
    return std::nullopt;
  }
  auto light = SeeAreaPoint(world, lights, {hit->id, hit->b1, hit->b2}, choice.pdf, p.x);
  if (light) {
    light->pdf = choice.pdf;
    light->is_visible = true;
  }
  return light;
}

/// Empty at the light's own place.
template <class Accepts = AcceptsAll>
[[gnu::always_inline]] inline std::optional<SeenLight> SeePointLight(
    const LightSet::PointLight& point, const Vec3& x, Accepts accepts = {}) {
  const Vec3 to_light = point.position - x;
  const double distance2 = SquaredNorm(to_light);
  if (!(distance2 > 0.0)) {
    return std::nullopt;
  }
  SeenLight light{&point};
  light.distance = std::sqrt(distance2);
  light.w = to_light * (1.0 / light.distance);
  if (!accepts(light.w)) {
    return std::nullopt;
  }
  light.radiance = IntensityTowards(point, -light.w);
  light.pdf = distance2;
  return light;
}

template <class Accepts = AcceptsAll>
[[gnu::always_inline]] inline std::optional<SeenLight> SeeDirectional(
    const LightSet::Directional& directional, Accepts accepts = {}) {
  if (!accepts(directional.to_light)) {
    return std::nullopt;
  }
  SeenLight light{&directional, directional.to_light};
  light.radiance = directional.irradiance;
  return light;
}

/// A drawn direction; empty if its density is zero.
template <class Accepts = AcceptsAll>
[[gnu::always_inline]] inline std::optional<SeenLight> SeeEnvironment(
    const LightSet::Environment& environment, const DirectionSample& sample, Accepts accepts = {}) {
  std::optional<SeenLight> result;
  if (!(sample.pdf > 0.0)) {
    return result;
  }
  const Vec3 w = environment.world_from_light * sample.direction;
  if (!accepts(w)) {
    return result;
  }
  SeenLight& light = result.emplace();
  light.end = &environment;
  light.w = w;
  light.radiance = EnvironmentRadianceAt(*environment.light, sample.uv);
  light.pdf = sample.pdf;
  light.has_extent = true;
  return result;
}

/// Directions to an environment where there is no receiver whose hemisphere a constant one could be
/// drawn over: then over the sphere.
inline DirectionSample SampleWithoutReceiver(const LightSet::Environment& environment,
                                             double u0,
                                             double u1) {
  if (environment.light->texels.size() > 1) {
    return environment.sampler->Sample({}, u0, u1);
  }
  DirectionSample sample;
  sample.direction = SampleUniformSphere(u0, u1);
  sample.pdf = 0.25 * std::numbers::inv_pi;
  return sample;
}
/// `w` in the world.
inline double PdfWithoutReceiver(const LightSet::Environment& environment, const Vec3& w) {
  return environment.light->texels.size() > 1
             ? environment.sampler->Pdf(UvTowards(environment, w), true)
             : 0.25 * std::numbers::inv_pi;
}

/// A shadow ray's length to a point `end`: short of it by what rays can tell apart there.
inline double ShadowDistance(const RayCaster& caster, double distance, const Vec3& end) {
  return distance * (1.0 - kShadowShortening) - 2.0 * caster.Offset(end);
}

/// From a surface point to a light that it sees. The ray starts off the surface and must end at the
/// light's own point all the same: beside it, a light seen edge-on would hide itself.
[[gnu::always_inline]] inline Segment ShadowRay(const RayCaster& caster,
                                                const SurfacePoint& p,
                                                const SeenLight& light) {
  const Vec3 origin = RayStart(p, light.w);
  if (std::isinf(light.distance)) {
    return {{origin, light.w}, light.distance};
  }
  const Vec3 to_light = p.x + light.w * light.distance - origin;
  const double length = Norm(to_light);
  return {{origin, to_light * (1.0 / length)}, ShadowDistance(caster, length, origin + to_light)};
}

}  // namespace pathfit::renderer
