#pragma once

#include <cmath>
#include <limits>

#include "renderer/math/frame.h"
#include "renderer/math/warp.h"
#include "renderer/path/surface_point.h"
#include "renderer/sampler/path_sampler.h"
#include "renderer/scene/light_set.h"
#include "renderer/scene/view_bounds.h"

namespace pathfit::renderer {

/// Everything a path needs, prepared once per view.
struct PathContext {
  const World* world = nullptr;
  LightSet lights;
  PixelBounds bounds;  ///< rays of pixels outside meet nothing
  int max_bounces = 1;
  int rr_depth = 5;
  bool antithetic = false;  ///< paths come in pairs, the second mirrored at its first rough vertex

  [[nodiscard]] bool HasExtendedLights() const {
    return lights.environment.has_value() || !lights.areas.empty();
  }
};

/// Light that reaches a vertex directly from an emitter, as light sampling (or, for the
/// environment, a BSDF sample that escapes) meets it. Adds bsdf(wi, wo) * factor * radiance to what
/// leaves the vertex; at a delta vertex the delta weight stands for bsdf.
struct DirectContribution {
  int emitter = -1;
  Vec3 wi;                ///< unit, towards the light
  double distance = 0.0;  ///< of a point or area light; 0 at infinity
  double factor = 0.0;    ///< cosine * MIS weight / density (and 1/r^2 for points)
  Rgb radiance;           ///< radiance, intensity or irradiance
  TriangleId id;          ///< area lights: the point that shines
  double b1 = 0.0, b2 = 0.0;
};

/// How a path goes on: radiance beyond is weighted with bsdf(wi, wo) * factor, or with the delta
/// weight * factor.
struct Continuation {
  Vec3 wi;
  double factor = 0.0;
  bool delta = false;
  bool transmit = false;  ///< delta only
};

/// Listens to one path; vertices come in order from the sensor. The primal listens with
/// NullPathRecorder, at no cost.
struct NullPathRecorder {
  /// Whether contributions of value zero are wanted, too: their derivative may not vanish.
  static constexpr bool kDifferentiates = false;
  void OnVertex(const SurfacePoint&) {}
  /// The last vertex shines towards its viewer; `weight` is the MIS weight.
  void OnEmission(const LightSet::AreaLight&, double /*weight*/) {}
  void OnDirect(const DirectContribution&) {}
  void OnContinue(const Continuation&) {}
  /// `radiance` was added that was reflected `bounces` times.
  void OnRadiance(int /*bounces*/, const Rgb& /*radiance*/) {}
  /// Whether light that arrives at the path's last vertex matters.
  [[nodiscard]] bool WantsLight() const { return true; }
};

inline Rgb EnvironmentRadianceInWorld(const LightSet::Environment& environment,
                                      const Vec3& direction) {
  return EnvironmentRadianceAt(*environment.light,
                               EnvironmentUv(environment.light_from_world * direction));
}

/// Russian roulette survival probability from the path's throughput.
inline double SurvivalProbability(const Rgb& throughput) {
  return std::min(0.95, std::max(0.05, MaxChannel(throughput)));
}

/// A shadow ray's length to a point: short of it by the offset at both ends.
inline double ShadowDistance(const RayCaster& caster, double distance) {
  return distance * (1.0 - kShadowShortening) - 2.0 * caster.Offset();
}

/// Whether nothing lies between a vertex and a light in unit direction wi; `distance` 0 means at
/// infinity. The ray starts off the surface and must end at the light's own point all the same:
/// beside it, a light seen edge-on would hide itself.
inline bool LightVisible(const RayCaster& caster,
                         const SurfacePoint& p,
                         const Vec3& wi,
                         double distance) {
  const Vec3 origin = RayStart(caster, p, wi);
  if (!(distance > 0.0)) {
    return !caster.Occluded({origin, wi}, std::numeric_limits<double>::infinity());
  }
  const Vec3 to_light = p.x + wi * distance - origin;
  const double length = Norm(to_light);
  return !caster.Occluded({origin, to_light * (1.0 / length)}, ShadowDistance(caster, length));
}

/// The family of directions that one vertex draws from.
struct DirectionFamily {
  DirectionDraw draw = DirectionDraw::kBsdf;
  bool paired = false;    ///< BSDF samples of two paths, the second mirrored
  bool mirrored = false;  ///< this is the second
};

/// Density of the directions of a family, as MIS sees it.
inline double ScatterPdf(const SurfacePoint& p,
                         const BsdfCosines& cosines,
                         const DirectionFamily& family) {
  const Bsdf& bsdf = p.material->bsdf;
  const double pdf =
      family.paired ? MirroredPairPdf(bsdf, p.inputs, cosines) : BsdfPdf(bsdf, p.inputs, cosines);
  if (family.draw == DirectionDraw::kBsdf) {
    return pdf;
  }
  const double spread = IsTransmissive(bsdf) ? 2.0 : 1.0;
  return 0.5 * (pdf + UniformHemispherePdf() / spread);
}

/// The next direction at a vertex; its density is the family's.
template <class Sampler>
std::optional<BsdfSample> SampleDirection(const SurfacePoint& p,
                                          int bounce,
                                          const DirectionFamily& family,
                                          Sampler& sampler) {
  const Bsdf& bsdf = p.material->bsdf;
  const double u0 = sampler.NextDirection(bounce, 0);
  const double u1 = sampler.NextDirection(bounce, 1);
  const double u2 = sampler.Next();
  std::optional<BsdfSample> sample;
  if (family.draw == DirectionDraw::kMixedUniform) {
    Vec3 local =
        IsTransmissive(bsdf) ? SampleUniformSphere(u0, u1) : SampleUniformHemisphere(u0, u1);
    if (family.mirrored) {
      local = {-local.x, -local.y, local.z};
    }
    sample = BsdfSample{Frame::FromNormal(p.n).ToWorld(local)};
  } else {
    sample = SampleBsdf(bsdf, p.inputs, p.n, p.wo, u0, u1, u2, family.mirrored);
  }
  if (sample && (family.paired || family.draw != DirectionDraw::kBsdf) && !sample->delta) {
    sample->pdf = ScatterPdf(p, p.Cosines(sample->wi), family);
  }
  return sample;
}

/// Share of a sample drawn with density `own` that `other` could have drawn, too. The square,
/// rather than the density itself, leaves narrow lobes to the samples that follow them: their
/// derivatives are large, and only those samples cancel in antithetic pairs. [Veach1995]
inline double PowerHeuristic(double own, double other) {
  return own * own / (own * own + other * other);
}

/// How far a path goes and what it counts.
struct PathRange {
  int max_bounces = 1;        ///< light that was reflected up to so many times
  bool with_emission = true;  ///< the first vertex' own emission
  bool mirrored = false;      ///< the second path of an antithetic pair
};

/// Light sampling at a non-delta vertex: one sample of the environment and one of the area lights
/// (MIS with the BSDF, power heuristic), all point and directional lights.
template <class Sampler, class Recorder>
Rgb SampleLights(const PathContext& context,
                 const SurfacePoint& p,
                 const DirectionFamily& family,
                 Sampler& sampler,
                 Recorder& recorder) {
  const RayCaster& caster = context.world->caster();
  const LightSet& lights = context.lights;
  Rgb sum;
  const auto add = [&](const DirectContribution& direct, const Rgb& bsdf) {
    if (!Recorder::kDifferentiates && IsBlack(bsdf * direct.radiance)) {
      return;
    }
    if (LightVisible(caster, p, direct.wi, direct.distance)) {
      recorder.OnDirect(direct);
      sum += bsdf * direct.radiance * direct.factor;
    }
  };
  if (lights.environment) {
    const auto& environment = *lights.environment;
    const double u0 = sampler.NextLight();
    const double u1 = sampler.NextLight();
    const DirectionSample sample =
        environment.sampler->Sample(environment.light_from_world * p.n, u0, u1);
    const Vec3 wi = environment.world_from_light * sample.direction;
    if (sample.pdf > 0.0 && p.Accepts(wi)) {
      const BsdfCosines cosines = p.Cosines(wi);
      const double other = ScatterPdf(p, cosines, family);
      add({environment.emitter,
           wi,
           0.0,
           std::abs(cosines.cos_i) * PowerHeuristic(sample.pdf, other) / sample.pdf,
           EnvironmentRadianceAt(*environment.light, sample.uv),
           {}},
          EvalBsdf(p.material->bsdf, p.inputs, cosines));
    }
  }
  if (!lights.areas.empty()) {
    const double u0 = sampler.NextLight();
    const double u1 = sampler.NextLight();
    const AreaSample sample = lights.area_sampler->Sample(u0, u1);
    const TriangleGeometry& triangle = caster.Geometry(sample.id);
    const Vec3 to_light = triangle.Point(sample.b1, sample.b2) - p.x;
    const double distance2 = SquaredNorm(to_light);
    const double distance = std::sqrt(distance2);
    const Vec3 wi = to_light * (1.0 / distance);
    const double cos_light = -Dot(triangle.n, wi);
    if (distance2 > 0.0 && cos_light != 0.0 && p.Accepts(wi)) {
      const LightSet::AreaLight& light = *lights.AreaLightOf(sample.id.mesh);
      const double side = cos_light > 0.0 ? 1.0 : -1.0;
      if (side > 0.0 || light.light->two_sided) {
        const Rgb radiance = AreaRadiance(light, sample.id.triangle, sample.b1, sample.b2, side);
        const BsdfCosines cosines = p.Cosines(wi);
        const double pdf = sample.pdf * distance2 / std::abs(cos_light);
        const double other = ScatterPdf(p, cosines, family);
        add({light.emitter,
             wi,
             distance,
             std::abs(cosines.cos_i) * PowerHeuristic(pdf, other) / pdf,
             radiance,
             sample.id,
             sample.b1,
             sample.b2},
            EvalBsdf(p.material->bsdf, p.inputs, cosines));
      }
    }
  }
  for (const auto& light : lights.points) {
    const Vec3 to_light = light.position - p.x;
    const double distance2 = SquaredNorm(to_light);
    const double distance = std::sqrt(distance2);
    const Vec3 wi = to_light * (1.0 / distance);
    if (distance2 > 0.0 && p.Accepts(wi)) {
      const BsdfCosines cosines = p.Cosines(wi);
      add({light.emitter,
           wi,
           distance,
           std::abs(cosines.cos_i) / distance2,
           IntensityTowards(light, -wi),
           {}},
          EvalBsdf(p.material->bsdf, p.inputs, cosines));
    }
  }
  for (const auto& light : lights.directionals) {
    if (p.Accepts(light.to_light)) {
      const BsdfCosines cosines = p.Cosines(light.to_light);
      add({light.emitter, light.to_light, 0.0, std::abs(cosines.cos_i), light.irradiance, {}},
          EvalBsdf(p.material->bsdf, p.inputs, cosines));
    }
  }
  return sum;
}

/// Draws the numbers of SampleLights.
template <class Sampler>
void SkipLights(const PathContext& context, Sampler& sampler) {
  const int extended =
      (context.lights.environment ? 1 : 0) + (context.lights.areas.empty() ? 0 : 1);
  for (int i = 0; i < 2 * extended; ++i) {
    sampler.NextLight();
  }
}

/// Radiance leaving a surface point towards where it is seen from: unidirectional path tracing with
/// light sampling and MIS at every vertex.
template <class Sampler, class Recorder>
Rgb TraceRadiance(const PathContext& context,
                  SurfacePoint p,
                  Sampler& sampler,
                  Recorder& recorder,
                  const PathRange& range) {
  Rgb radiance;
  Rgb throughput{1.0, 1.0, 1.0};
  // Mirroring a second vertex, too, would pair only two of the four combinations of densities.
  bool paired = context.antithetic;
  double emission_weight = range.with_emission ? 1.0 : 0.0;
  const auto add = [&](int bounces, const Rgb& value) {
    radiance += value;
    recorder.OnRadiance(bounces, value);
  };
  for (int bounce = 1;; ++bounce) {
    recorder.OnVertex(p);
    if (const auto* light = context.lights.AreaLightOf(p.id.mesh);
        light != nullptr && emission_weight > 0.0) {
      recorder.OnEmission(*light, emission_weight);
      add(bounce - 1,
          throughput * AreaRadiance(*light, p.id.triangle, p.b1, p.b2, p.side) * emission_weight);
    }
    if (bounce > range.max_bounces || !p.Reflects()) {
      break;
    }
    const bool delta = IsDelta(p.material->bsdf);
    const DirectionFamily family{sampler.DrawAt(bounce), paired, paired && range.mirrored};
    const bool wants_light = recorder.WantsLight();
    if (!wants_light && bounce == range.max_bounces) {
      break;
    }
    if (!delta) {
      if (wants_light) {
        add(bounce, throughput * SampleLights(context, p, family, sampler, recorder));
      } else {
        SkipLights(context, sampler);
      }
      if (bounce == range.max_bounces && !context.HasExtendedLights()) {
        break;
      }
    }
    const auto sample = SampleDirection(p, bounce, family, sampler);
    paired = paired && delta;
    if (!sample || !(sample->pdf > 0.0) || !p.Accepts(sample->wi)) {
      break;
    }
    const BsdfCosines cosines = p.Cosines(sample->wi);
    const double pdf = sample->pdf;
    const Continuation on{
        sample->wi, delta ? 1.0 / pdf : std::abs(cosines.cos_i) / pdf, delta, cosines.cos_i < 0.0};
    const Rgb bsdf = delta ? EvalDelta(p.material->bsdf, p.inputs, cosines.cos_o, on.transmit).value
                           : EvalBsdf(p.material->bsdf, p.inputs, cosines);
    const Ray ray{RayStart(context.world->caster(), p, sample->wi), sample->wi};
    std::optional<Hit> hit;
    bool escaped = false;
    if (bounce == range.max_bounces && context.lights.areas.empty() && !delta) {
      escaped = !context.world->caster().Occluded(ray, std::numeric_limits<double>::infinity());
    } else {
      hit = context.world->caster().Intersect(ray);
      escaped = !hit;
    }
    if (escaped && context.lights.environment) {
      const auto& environment = *context.lights.environment;
      const Vec2 uv = EnvironmentUv(environment.light_from_world * sample->wi);
      const double other = delta ? 0.0 : environment.sampler->Pdf(uv, cosines.cos_i > 0.0);
      const DirectContribution direct{environment.emitter,
                                      sample->wi,
                                      0.0,
                                      on.factor * PowerHeuristic(pdf, other),
                                      EnvironmentRadianceAt(*environment.light, uv),
                                      {}};
      if (delta) {
        recorder.OnContinue(on);
      }
      recorder.OnDirect(direct);
      add(bounce, throughput * bsdf * direct.radiance * direct.factor);
    }
    const bool can_go_on =
        hit && (bounce < range.max_bounces ||
                context.lights.area_of_mesh[static_cast<std::size_t>(hit->id.mesh)] >= 0);
    if (!can_go_on) {
      break;
    }
    Continuation next = on;
    throughput *= bsdf * on.factor;
    if (bounce >= context.rr_depth) {
      const double survival = SurvivalProbability(throughput);
      if (sampler.Next() >= survival) {
        break;
      }
      next.factor /= survival;
      throughput *= 1.0 / survival;
    }
    recorder.OnContinue(next);
    p = MakeSurfacePoint(*context.world, *hit, ray);
    emission_weight = 1.0;
    if (!delta && context.lights.area_of_mesh[static_cast<std::size_t>(p.id.mesh)] >= 0) {
      const double cos_light = std::abs(Dot(p.ng, ray.direction));
      const double other = context.lights.area_sampler->Pdf(p.id) * hit->distance * hit->distance;
      emission_weight = PowerHeuristic(pdf * cos_light, other);
    }
  }
  return radiance;
}

}  // namespace pathfit::renderer
