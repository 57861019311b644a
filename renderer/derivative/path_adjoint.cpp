#include "renderer/derivative/path_adjoint.h"

#include <algorithm>

#include "renderer/derivative/geometry_scatter.h"

namespace pathfit::renderer {
namespace {

using Vertex = PathRecorder::Vertex;

class Sweep {
 public:
  Sweep(const AdjointContext& context,
        const PixelSample& pixel,
        PathRecorder& path,
        DerivativeAccumulator& sum)
      : context_(context.path),
        camera_(context.camera),
        active_(context.active),
        form_(context.form),
        pixel_(pixel),
        vertices_(path.vertices),
        contact_(path.contact),
        directs_(path.directs),
        target_(sum),
        motion_(*context.path.world, camera_, active_, target_),
        appearance_(context.path, active_, sum) {}

  void Run() {
    const std::size_t count = vertices_.size();
    moving_ = IsMoving();
    if (!moving_ && !active_.any_material && !active_.any_light) {
      return;
    }
    Rgb throughput = Rgb::Constant(pixel_.weight);
    bool seen_rough = false;
    frozen_ = contact_ < count ? contact_ + 1 : count;
    for (std::size_t k = 0; k < count; ++k) {
      Vertex& v = vertices_[k];
      v.throughput = throughput;
      const bool delta = IsDelta(v.p.material->bsdf);
      if (!delta && !seen_rough) {
        seen_rough = true;
        first_rough_ = k;
      } else if (delta && seen_rough) {
        frozen_ = std::min(frozen_, k);
      }
      if (v.continues) {
        throughput *= Weight(v) * v.on.factor;
      }
    }
    if (!seen_rough) {
      first_rough_ = count - 1;
    }
    Rgb beyond;  // radiance leaving vertex k + 1 towards vertex k
    for (std::size_t k = count; k-- > 0;) {
      beyond = AdjointOfVertex(k, beyond);
    }
    if (moving_) {
      GeometryScatter(
          {{context_, camera_, active_, form_, nullptr}, pixel_, vertices_, motion_, appearance_})
          .Run(beyond, first_rough_, frozen_);
    }
    if (active_.any_material) {
      for (const Vertex& v : vertices_) {
        appearance_.Material(v);
      }
    }
  }

 private:
  [[nodiscard]] static Rgb Weight(const Vertex& v) {
    const BsdfCosines c = v.p.Cosines(v.on.wi);
    return v.on.delta ? EvalDelta(v.p.material->bsdf, v.p.inputs, c.cos_o, v.on.transmit).value
                      : EvalBsdf(v.p.material->bsdf, v.p.inputs, c);
  }
  [[nodiscard]] bool Moves(std::size_t k) const { return moving_ && k < frozen_; }
  /// Whether directions away from the sensor turn with the vertex' and its target's motion.
  [[nodiscard]] bool Turns(std::size_t k) const { return Moves(k) && k != contact_; }

  /// Whether anything that moves or bends touches the path.
  [[nodiscard]] bool IsMoving() const {
    const auto bends = [&](const Vertex& v) {
      return active_
          .materials[static_cast<std::size_t>(
              context_.world->scene().meshes[static_cast<std::size_t>(v.p.id.mesh)].material)]
          .bends;
    };
    if (active_.any_bends && std::any_of(vertices_.begin(), vertices_.end(), bends)) {
      return true;
    }
    if (!active_.any_geometry || active_.camera.Any() || active_.any_light_moves) {
      return active_.any_geometry;
    }
    const auto touches = [&](TriangleId id) {
      return active_.meshes[static_cast<std::size_t>(id.mesh)].any_geometry;
    };
    return std::any_of(vertices_.begin(),
                       vertices_.end(),
                       [&](const Vertex& v) { return touches(v.p.id); }) ||
           std::any_of(directs_.begin(), directs_.end(), [&](const DirectContribution& d) {
             return d.id.IsValid() && touches(d.id);
           });
  }

  /// All that leaves vertex k, for throughput 1; leaves its derivative in the vertices.
  Rgb AdjointOfVertex(std::size_t k, const Rgb& beyond) {
    Vertex& v = vertices_[k];
    Rgb leaving;
    if (v.emission_weight > 0.0) {
      const LightSet::AreaLight& light = *context_.lights.AreaLightOf(v.p.id.mesh);
      v.emission = v.throughput * v.emission_weight;
      appearance_.AreaEmission(light, v.p.id, v.p.b1, v.p.b2, v.p.side, v.emission);
      leaving += AreaRadiance(light, v.p.id.triangle, v.p.b1, v.p.b2, v.p.side) * v.emission_weight;
    }
    for (std::size_t i = v.first_direct; i < v.end_direct; ++i) {
      leaving += v.continues && v.on.delta ? AdjointOfEscape(k, directs_[i])
                                           : AdjointOfDirect(k, directs_[i]);
    }
    if (v.continues && k + 1 < vertices_.size()) {
      leaving += v.on.delta ? AdjointOfDelta(k, beyond) : AdjointOfSegment(k, beyond);
    }
    return leaving;
  }

  Rgb AdjointOfDirect(std::size_t k, const DirectContribution& direct) {
    Vertex& v = vertices_[k];
    const Rgb weight = v.throughput * direct.radiance * direct.factor;
    ColorGradient d_wi;
    const Rgb bsdf = AdjointOfBsdf(k, direct.wi, weight, d_wi);
    const Rgb per_radiance = v.throughput * bsdf * direct.factor;
    if (direct.id.IsValid()) {
      AdjointOfAreaPoint(k, direct, d_wi, weight * bsdf, per_radiance);
    } else if (direct.distance > 0.0) {
      AdjointOfPointLight(k, direct, d_wi, weight * bsdf, per_radiance);
    } else {
      if (Turns(k) && motion_.LightMoves(direct.emitter)) {
        motion_.LightSpin(direct.emitter, Cross(direct.wi, d_wi));
      }
      const auto& environment = context_.lights.environment;
      if (environment && environment->emitter == direct.emitter) {
        appearance_.Environment(*environment, direct.wi, per_radiance);
      } else {
        for (const auto& light : context_.lights.directionals) {
          if (light.emitter == direct.emitter) {
            appearance_.Irradiance(light, per_radiance);
          }
        }
      }
    }
    return bsdf * direct.radiance * direct.factor;
  }

  /// Both ends are material points: G J attached.
  void AdjointOfAreaPoint(std::size_t k,
                          const DirectContribution& direct,
                          ColorGradient d_wi,
                          const Rgb& value,
                          const Rgb& per_radiance) {
    Vertex& v = vertices_[k];
    const LightSet::AreaLight& light = *context_.lights.AreaLightOf(direct.id.mesh);
    const TriangleGeometry& triangle = context_.world->caster().Geometry(direct.id);
    const double cos_light = Dot(triangle.n, direct.wi);
    appearance_.AreaEmission(
        light, direct.id, direct.b1, direct.b2, cos_light < 0.0 ? 1.0 : -1.0, per_radiance);
    if (!Turns(k)) {
      return;
    }
    d_wi += Outer(triangle.n, value * (1.0 / cos_light));
    const ColorGradient d_y = EndPointAdjoint(direct.wi, direct.distance, d_wi) -
                              Outer(direct.wi, value * (2.0 / direct.distance));
    v.d_x -= d_y;
    motion_.MaterialPoint(
        direct.id, direct.b1, direct.b2, d_y, Outer(direct.wi, value * (1.0 / cos_light)), value);
  }

  void AdjointOfPointLight(std::size_t k,
                           const DirectContribution& direct,
                           ColorGradient d_wi,
                           const Rgb& value,
                           const Rgb& per_radiance) {
    Vertex& v = vertices_[k];
    for (const auto& light : context_.lights.points) {
      if (light.emitter != direct.emitter) {
        continue;
      }
      const IntensityPartials partials = IntensityDerivative(light, -direct.wi);
      appearance_.Intensity(light, partials, per_radiance);
      if (!Turns(k)) {
        return;
      }
      ColorGradient d_w;  // by the direction from the light
      for (int c = 0; c < 3; ++c) {
        d_w[c] = partials.d_w[static_cast<std::size_t>(c)] * per_radiance[c];
      }
      d_wi -= d_w;
      const ColorGradient d_light = EndPointAdjoint(direct.wi, direct.distance, d_wi) -
                                    Outer(direct.wi, value * (2.0 / direct.distance));
      v.d_x -= d_light;
      if (motion_.LightMoves(direct.emitter)) {
        motion_.LightPosition(direct.emitter, light.position, d_light);
        motion_.LightSpin(direct.emitter, Cross(direct.wi, d_w));
      }
    }
  }

  /// Segment x_k -> x_{k+1}: bsdf at k, geometry term of both ends, area ratio of the far one.
  Rgb AdjointOfSegment(std::size_t k, const Rgb& beyond) {
    Vertex& v = vertices_[k];
    Vertex& next = vertices_[k + 1];
    const Rgb weight = v.throughput * beyond * v.on.factor;
    ColorGradient d_wi;
    const Rgb bsdf = AdjointOfBsdf(k, v.on.wi, weight, d_wi);
    if (Turns(k) && Moves(k + 1)) {
      const Rgb value = weight * bsdf;
      const double r = Norm(next.p.x - RayStart(context_.world->caster(), v.p, v.on.wi));
      const Rgb per_cos = value * (1.0 / Dot(next.p.ng, v.on.wi));
      next.d_ng += Outer(v.on.wi, per_cos);
      d_wi += Outer(next.p.ng, per_cos);
      const ColorGradient d_end =
          EndPointAdjoint(v.on.wi, r, d_wi) - Outer(v.on.wi, value * (2.0 / r));
      next.d_x += d_end;
      MoveStart(context_.world->caster(), v, -d_end);
      next.d_log_area += value;
    }
    return bsdf * beyond * v.on.factor;
  }

  /// Adjoint of weight * bsdf * (cosine, which is inside weight) at vertex k for incident direction
  /// wi: fills the vertex' own adjoints, adds to d_wi, and returns the bsdf.
  Rgb AdjointOfBsdf(std::size_t k, const Vec3& wi, const Rgb& weight, ColorGradient& d_wi) {
    Vertex& v = vertices_[k];
    const BsdfCosines cosines = v.p.Cosines(wi);
    const BsdfPartials f = EvalBsdfPartials(v.p.material->bsdf, v.p.inputs, cosines);
    v.d_base_color += weight * f.d_base_color;
    v.d_roughness += weight * f.d_roughness;
    v.d_metallic += weight * f.d_metallic;
    v.d_eta += weight * f.d_eta;
    v.d_k += weight * f.d_k;
    if (Moves(k)) {
      const Rgb by_cos_i = weight * (f.d_cos_i + f.value * (1.0 / cosines.cos_i));
      const Rgb by_cos_o = weight * f.d_cos_o;
      const Rgb by_dot = weight * f.d_dot_io;
      v.d_n += Outer(wi, by_cos_i) + Outer(v.p.wo, by_cos_o);
      v.d_wo += Outer(v.p.n, by_cos_o) + Outer(wi, by_dot);
      d_wi += Outer(v.p.n, by_cos_i) + Outer(v.p.wo, by_dot);
    }
    return f.value;
  }

  /// Weight of a mirror or glass vertex; returns it.
  Rgb AdjointOfDeltaWeight(std::size_t k, const Rgb& weight) {
    Vertex& v = vertices_[k];
    const DeltaPartials f =
        EvalDelta(v.p.material->bsdf, v.p.inputs, Dot(v.p.n, v.p.wo), v.on.transmit);
    v.d_base_color += weight * f.d_base_color;
    v.d_eta += weight * f.d_eta;
    v.d_k += weight * f.d_k;
    if (Moves(k)) {
      v.d_n += Outer(v.p.wo, weight * f.d_cos_o);
      v.d_wo += Outer(v.p.n, weight * f.d_cos_o);
    }
    return f.value;
  }

  Rgb AdjointOfDelta(std::size_t k, const Rgb& beyond) {
    const Vertex& v = vertices_[k];
    return AdjointOfDeltaWeight(k, v.throughput * beyond * v.on.factor) * beyond * v.on.factor;
  }

  /// The environment behind a mirror or glass.
  Rgb AdjointOfEscape(std::size_t k, const DirectContribution& direct) {
    Vertex& v = vertices_[k];
    const LightSet::Environment& environment = *context_.lights.environment;
    const Rgb value = AdjointOfDeltaWeight(k, v.throughput * direct.radiance * direct.factor);
    const Rgb per_radiance = v.throughput * value * direct.factor;
    appearance_.Environment(environment, direct.wi, per_radiance);
    if (Moves(k)) {
      const ColorGradient d_wi = SkyGradient(environment, direct.wi, per_radiance);
      v.d_wi += d_wi;
      motion_.LightSpin(direct.emitter, -Cross(direct.wi, d_wi));
    }
    return value * direct.radiance * direct.factor;
  }

  const PathContext& context_;
  const CameraModel& camera_;
  const ActiveParameters& active_;
  DerivativeForm form_;
  const PixelSample& pixel_;
  std::vector<Vertex>& vertices_;
  const std::size_t contact_;  // the vertex whose directions away from it are kept fixed
  const std::vector<DirectContribution>& directs_;
  AccumulatorTarget target_;
  MotionAdjoint<ColorGradient, AccumulatorTarget> motion_;
  AppearanceAdjoint appearance_;
  bool moving_ = false;
  std::size_t first_rough_ = 0;  // the first vertex that is no mirror or glass
  std::size_t frozen_ = 0;       // vertices from here on do not move
};

}  // namespace

void AccumulatePathAdjoint(const AdjointContext& context,
                           const PixelSample& pixel,
                           PathRecorder& path,
                           DerivativeAccumulator& sum) {
  Sweep(context, pixel, path, sum).Run();
}

}  // namespace pathfit::renderer
