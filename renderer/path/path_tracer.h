#pragma once

#include <cmath>
#include <limits>

#include "renderer/path/surface_point.h"
#include "renderer/scene/light_set.h"
#include "renderer/scene/view_bounds.h"

namespace pathfit::renderer {

/// Everything a path needs, prepared once per view.
struct PathContext {
  const Scene* scene = nullptr;
  const RayCaster* caster = nullptr;
  LightSet lights;
  PixelBounds bounds;  ///< rays of pixels outside meet nothing
  int max_bounces = 1;
  int rr_depth = 5;
};

/// Light that reaches a vertex directly from an emitter, as the path tracer meets it.
/// The contribution to the radiance leaving the vertex is bsdf(wi, wo) * factor * radiance.
struct DirectContribution {
  int emitter = -1;
  Vec3 wi;                ///< unit, towards the light
  double distance = 0.0;  ///< of a point light; 0 at infinity
  double factor = 0.0;    ///< cosine * MIS weight / density (and 1/r^2 for points)
  Rgb radiance;           ///< radiance, intensity or irradiance
};

/// Listens to one path; vertices come in order from the sensor. The primal listens with
/// NullPathRecorder, at no cost.
struct NullPathRecorder {
  void OnVertex(const SurfacePoint&) {}
  void OnDirect(const DirectContribution&) {}
  /// The path goes on in direction `wi`: radiance beyond is weighted with bsdf(wi, wo) * factor.
  void OnContinue(const Vec3& /*wi*/, const Rgb& /*bsdf*/, double /*factor*/) {}
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

/// Light sampling at a vertex: one sample of the environment (MIS with the BSDF, balance
/// heuristic), all delta lights.
template <class Sampler, class Recorder>
Rgb SampleLights(const PathContext& context,
                 const SurfacePoint& p,
                 Sampler& sampler,
                 Recorder& recorder) {
  const RayCaster& caster = *context.caster;
  const Vec3 origin = caster.OffsetPoint(p.x, p.n);
  const double cos_o = Dot(p.n, p.wo);
  Rgb sum;
  const auto add = [&](const DirectContribution& direct, const Rgb& bsdf, double max_distance) {
    if (!caster.Occluded({origin, direct.wi}, max_distance)) {
      recorder.OnDirect(direct);
      sum += bsdf * direct.radiance * direct.factor;
    }
  };
  if (context.lights.environment) {
    const auto& environment = *context.lights.environment;
    const double u0 = sampler.Next();
    const double u1 = sampler.Next();
    const DirectionSample sample =
        environment.sampler->Sample(environment.light_from_world * p.n, u0, u1);
    const Vec3 wi = environment.world_from_light * sample.direction;
    const BsdfCosines cosines{Dot(p.n, wi), cos_o, Dot(wi, p.wo)};
    if (cosines.cos_i > 0.0 && sample.pdf > 0.0) {
      const double other = BsdfPdf(p.material->bsdf, p.base_color, cosines);
      const double factor = cosines.cos_i / (sample.pdf + other);
      add({environment.emitter,
           wi,
           0.0,
           factor,
           EnvironmentRadianceAt(*environment.light, sample.uv)},
          EvalBsdf(p.material->bsdf, p.base_color, cosines),
          std::numeric_limits<double>::infinity());
    }
  }
  for (const auto& light : context.lights.points) {
    const Vec3 to_light = light.position - p.x;
    const double distance2 = SquaredNorm(to_light);
    const double distance = std::sqrt(distance2);
    const Vec3 wi = to_light / distance;
    const BsdfCosines cosines{Dot(p.n, wi), cos_o, Dot(wi, p.wo)};
    if (distance2 > 0.0 && cosines.cos_i > 0.0) {
      add({light.emitter, wi, distance, cosines.cos_i / distance2, light.intensity},
          EvalBsdf(p.material->bsdf, p.base_color, cosines),
          distance);
    }
  }
  for (const auto& light : context.lights.directionals) {
    const BsdfCosines cosines{Dot(p.n, light.to_light), cos_o, Dot(light.to_light, p.wo)};
    if (cosines.cos_i > 0.0) {
      add({light.emitter, light.to_light, 0.0, cosines.cos_i, light.irradiance},
          EvalBsdf(p.material->bsdf, p.base_color, cosines),
          std::numeric_limits<double>::infinity());
    }
  }
  return sum;
}

/// Radiance leaving a surface point towards where it is seen from: unidirectional path tracing with
/// light sampling and MIS at every vertex. `p` is vertex 1, so light after b bounces is counted for
/// b <= max_bounces.
template <class Sampler, class Recorder>
Rgb TraceRadiance(const PathContext& context,
                  SurfacePoint p,
                  Sampler& sampler,
                  Recorder& recorder) {
  Rgb radiance;
  Rgb throughput{1.0, 1.0, 1.0};
  for (int bounce = 1; bounce <= context.max_bounces && p.Reflects(); ++bounce) {
    recorder.OnVertex(p);
    radiance += throughput * SampleLights(context, p, sampler, recorder);

    const bool last = bounce == context.max_bounces;
    if (last && !context.lights.environment) {
      break;
    }
    const double u0 = sampler.Next();
    const double u1 = sampler.Next();
    const double u2 = sampler.Next();
    const auto sample = SampleBsdf(p.material->bsdf, p.base_color, p.n, p.wo, u0, u1, u2);
    if (!sample || !(sample->pdf > 0.0)) {
      break;
    }
    const BsdfCosines cosines{Dot(p.n, sample->wi), Dot(p.n, p.wo), Dot(sample->wi, p.wo)};
    const Rgb bsdf = EvalBsdf(p.material->bsdf, p.base_color, cosines);
    const Ray ray{context.caster->OffsetPoint(p.x, p.n), sample->wi};
    std::optional<Hit> hit;
    bool escaped = false;
    if (last) {
      escaped = !context.caster->Occluded(ray, std::numeric_limits<double>::infinity());
    } else {
      hit = context.caster->Intersect(ray);
      escaped = !hit;
    }
    if (escaped && context.lights.environment) {
      const auto& environment = *context.lights.environment;
      const Vec2 uv = EnvironmentUv(environment.light_from_world * sample->wi);
      const double other = environment.sampler->Pdf(uv);
      const DirectContribution direct{environment.emitter,
                                      sample->wi,
                                      0.0,
                                      cosines.cos_i / (sample->pdf + other),
                                      EnvironmentRadianceAt(*environment.light, uv)};
      recorder.OnDirect(direct);
      radiance += throughput * bsdf * direct.radiance * direct.factor;
    }
    if (!hit) {
      break;
    }
    double factor = cosines.cos_i / sample->pdf;
    throughput *= bsdf * factor;
    if (bounce >= context.rr_depth) {
      const double survival = SurvivalProbability(throughput);
      if (sampler.Next() >= survival) {
        break;
      }
      factor /= survival;
      throughput *= 1.0 / survival;
    }
    recorder.OnContinue(sample->wi, bsdf, factor);
    p = MakeSurfacePoint(*context.scene, *context.caster, *hit, ray);
  }
  return radiance;
}

}  // namespace pathfit::renderer
