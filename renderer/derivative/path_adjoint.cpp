#include "renderer/derivative/path_adjoint.h"

#include <algorithm>
#include <bit>
#include <cstddef>

namespace pathfit::renderer {
namespace {

/// Moves the adjoint of a unit vector (b - a) / r to its end point b; the start point receives the
/// negative.
ColorGradient EndPointAdjoint(const Vec3& unit, double r, const ColorGradient& adjoint) {
  return (adjoint - Outer(unit, Dot(unit, adjoint))) * (1.0 / r);
}

/// Gradient of weight * sky radiance by the world direction.
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

DeltaPartials DeltaWeight(const PathRecord::Vertex& v) {
  return EvalDelta(v.p.material->bsdf, v.p.inputs, Dot(v.p.n, v.p.wo), v.on.transmit);
}

/// By which what lies beyond the vertex is weighted, without the continuation's factor.
Rgb ScatterWeight(const PathRecord::Vertex& v) {
  return v.on.delta ? DeltaWeight(v).value
                    : EvalBsdf(v.p.material->bsdf, v.p.inputs, v.p.Cosines(v.on.wi));
}

}  // namespace

PathAdjoint::PathAdjoint(const AdjointContext& context, DerivativeAccumulator& sum)
    : context_(context.path),
      world_(*context.path.world),
      camera_(context.camera),
      active_(context.active),
      form_(context.form),
      target_(sum),
      motion_(world_, camera_, active_, target_),
      appearance_(context.path, active_, sum) {}

void PathAdjoint::AddPath(const PixelSample& pixel,
                          const PathRecord& path,
                          std::size_t contact,
                          NearMotion::VertexBits stand_ins,
                          VertexAdjoint* first) {
  pixel_ = &pixel;
  path_ = &path;
  contact_ = contact;
  stand_ins_ = stand_ins;
  moving_ = IsMoving();
  if (!moving_ && !active_.any_material && !active_.any_light) {
    return;
  }
  adjoints_.assign(path.vertices.size(), {});
  FindStages();
  Rgb beyond;  // radiance leaving vertex k + 1 towards vertex k
  for (std::size_t k = path.vertices.size(); k-- > 0;) {
    beyond = AdjointOfVertex(k, beyond);
  }
  const bool with_first = first == nullptr || !SharesFirst(path);
  if (moving_) {
    Scatter(beyond, with_first);
  }
  if (!with_first) {
    *first += adjoints_.front();
  }
  if (active_.any_material) {
    for (std::size_t k = with_first ? 0 : 1; k < path.vertices.size(); ++k) {
      appearance_.Material(path.vertices[k].p, adjoints_[k]);
    }
  }
}

void PathAdjoint::AddFirst(const PixelSample& pixel,
                           const PathRecord& path,
                           const VertexAdjoint& first) {
  pixel_ = &pixel;
  path_ = &path;
  adjoints_.assign(1, first);
  if (active_.any_geometry) {
    ScatterImagePoint(0);
  }
  if (active_.any_material) {
    appearance_.Material(path.vertices.front().p, first);
  }
}

bool PathAdjoint::IsMoving() const {
  const auto& vertices = path_->vertices;
  const auto bends = [&](const Vertex& v) {
    const SceneMesh& mesh = world_.scene().meshes[static_cast<std::size_t>(v.p.id.mesh)];
    return active_.materials[static_cast<std::size_t>(mesh.material)].bends;
  };
  if (active_.any_bends && std::any_of(vertices.begin(), vertices.end(), bends)) {
    return true;
  }
  if (!active_.any_geometry || active_.camera.Any() || active_.any_light_moves) {
    return active_.any_geometry;
  }
  const auto touches = [&](TriangleId id) {
    return active_.meshes[static_cast<std::size_t>(id.mesh)].any_geometry;
  };
  return std::any_of(
             vertices.begin(), vertices.end(), [&](const Vertex& v) { return touches(v.p.id); }) ||
         std::any_of(
             path_->directs.begin(), path_->directs.end(), [&](const DirectContribution& d) {
               const auto* y = std::get_if<MaterialPoint>(&d.light.end);
               return y != nullptr && touches(y->id);
             });
}

/// Throughputs, and where the path's vertices begin to be rough and to be frozen.
void PathAdjoint::FindStages() {
  const auto& vertices = path_->vertices;
  const std::size_t count = vertices.size();
  Rgb throughput = Rgb::Constant(pixel_->weight);
  bool seen_rough = false;
  frozen_ = contact_ < count ? contact_ + 1 : count;
  first_rough_ = count - 1;
  motion_weights_.assign(count + 1, 1.0);
  for (NearMotion::VertexBits left = stand_ins_; left != 0; left &= left - 1) {
    const auto behind = static_cast<std::ptrdiff_t>(std::countr_zero(left)) + 1;
    std::for_each(motion_weights_.begin() + behind, motion_weights_.end(), [](double& weight) {
      weight *= NearMotion::kStandInWeight;
    });
  }
  for (std::size_t k = 0; k < count; ++k) {
    const Vertex& v = vertices[k];
    adjoints_[k].throughput = throughput;
    const bool delta = IsDelta(v.p.material->bsdf);
    if (!delta && !seen_rough) {
      seen_rough = true;
      first_rough_ = k;
    } else if (delta && seen_rough) {
      frozen_ = std::min(frozen_, k);
    }
    if (v.continues) {
      throughput *= ScatterWeight(v) * v.on.factor;
    }
  }
}

/// All that leaves vertex k, for throughput 1; leaves its derivative in the adjoints.
Rgb PathAdjoint::AdjointOfVertex(std::size_t k, const Rgb& beyond) {
  const Vertex& v = path_->vertices[k];
  VertexAdjoint& d = adjoints_[k];
  Rgb leaving;
  if (v.emission_weight > 0.0) {
    const LightSet::AreaLight& light = *context_.lights.AreaLightOf(v.p.id.mesh);
    d.emission = d.throughput * v.emission_weight;
    appearance_.AreaEmission({v.p.id, v.p.b1, v.p.b2}, v.p.side, d.emission);
    leaving += AreaRadiance(light, v.p.id.triangle, v.p.b1, v.p.b2, v.p.side) * v.emission_weight;
  }
  for (std::size_t i = v.first_direct; i < v.end_direct; ++i) {
    const DirectContribution& direct = path_->directs[i];
    leaving += v.continues && v.on.delta ? AdjointOfEscape(k, direct) : AdjointOfDirect(k, direct);
  }
  if (v.continues && k + 1 < path_->vertices.size()) {
    leaving += v.on.delta ? AdjointOfDelta(k, beyond) : AdjointOfSegment(k, beyond);
  }
  return leaving;
}

Rgb PathAdjoint::AdjointOfDirect(std::size_t k, const DirectContribution& direct) {
  const SeenLight& light = direct.light;
  VertexAdjoint& d = adjoints_[k];
  const Rgb weight = d.throughput * light.radiance * direct.factor;
  ColorGradient d_wi;
  const Rgb bsdf = AdjointOfBsdf(k, light.w, weight, d_wi);
  const Rgb per_radiance = d.throughput * bsdf * direct.factor;
  Rgb value = weight * bsdf;
  const auto turn = [&](int emitter) {
    if (Moves(k) && motion_.LightMoves(emitter)) {
      motion_.LightSpin(emitter, Cross(light.w, d_wi));
    }
  };
  std::visit(Visitor{[&](const MaterialPoint& y) {  // both ends are material points: G J attached
                       const TriangleGeometry& triangle = world_.caster().Geometry(y.id);
                       const double cos_light = Dot(triangle.n, light.w);
                       appearance_.AreaEmission(y, cos_light < 0.0 ? 1.0 : -1.0, per_radiance);
                       if (!Turns(k)) {
                         return;
                       }
                       value *= TurnWeight(k);
                       d_wi = d_wi * (TurnWeight(k) / MotionWeight(k));
                       d_wi += Outer(triangle.n, value * (1.0 / cos_light));
                       const ColorGradient d_y = EndPointAdjoint(light.w, light.distance, d_wi) -
                                                 Outer(light.w, value * (2.0 / light.distance));
                       d.d_x -= d_y;
                       motion_.MaterialPoint(
                           y.id, y.b1, y.b2, d_y, Outer(light.w, value * (1.0 / cos_light)), value);
                     },
                     [&](const LightSet::PointLight* point) {
                       const IntensityPartials partials = IntensityDerivative(*point, -light.w);
                       appearance_.Intensity(*point, partials, per_radiance);
                       if (!Moves(k)) {
                         return;
                       }
                       value *= MotionWeight(k);
                       ColorGradient d_w;  // by the direction from the light
                       for (int c = 0; c < 3; ++c) {
                         d_w[c] = partials.d_w[static_cast<std::size_t>(c)] *
                                  (per_radiance[c] * MotionWeight(k));
                       }
                       d_wi -= d_w;
                       const ColorGradient d_light =
                           EndPointAdjoint(light.w, light.distance, d_wi) -
                           Outer(light.w, value * (2.0 / light.distance));
                       d.d_x -= d_light;
                       if (motion_.LightMoves(point->emitter)) {
                         motion_.LightPosition(point->emitter, point->position, d_light);
                         motion_.LightSpin(point->emitter, Cross(light.w, d_w));
                       }
                     },
                     [&](const LightSet::Directional* directional) {
                       turn(directional->emitter);
                       appearance_.Irradiance(*directional, per_radiance);
                     },
                     [&](const LightSet::Environment* environment) {
                       turn(environment->emitter);
                       appearance_.Environment(*environment, light.w, per_radiance);
                     }},
             light.end);
  return bsdf * light.radiance * direct.factor;
}

/// Segment x_k -> x_{k+1}: bsdf at k, geometry term of both ends, area ratio of the far one.
Rgb PathAdjoint::AdjointOfSegment(std::size_t k, const Rgb& beyond) {
  const Vertex& v = path_->vertices[k];
  const Rgb weight = adjoints_[k].throughput * beyond * v.on.factor;
  ColorGradient d_wi;
  const Rgb bsdf = AdjointOfBsdf(k, v.on.wi, weight, d_wi);
  if (Turns(k) && Moves(k + 1)) {
    const SurfacePoint& next = path_->vertices[k + 1].p;
    VertexAdjoint& d_next = adjoints_[k + 1];
    const Rgb value = weight * bsdf * TurnWeight(k);
    d_wi = d_wi * (TurnWeight(k) / MotionWeight(k));
    const double r = Norm(next.x - RayStart(v.p, v.on.wi));
    const Rgb per_cos = value * (1.0 / Dot(next.ng, v.on.wi));
    d_next.d_ng += Outer(v.on.wi, per_cos);
    d_wi += Outer(next.ng, per_cos);
    const ColorGradient d_end =
        EndPointAdjoint(v.on.wi, r, d_wi) - Outer(v.on.wi, value * (2.0 / r));
    d_next.d_x += d_end;
    MoveStart(k, -d_end);
    d_next.d_log_area += value;
  }
  return bsdf * beyond * v.on.factor;
}

/// Adjoint of weight * bsdf * (cosine, which is inside weight) at vertex k for incident direction
/// wi: fills the vertex' own adjoints, adds to d_wi, and returns the bsdf.
Rgb PathAdjoint::AdjointOfBsdf(std::size_t k,
                               const Vec3& wi,
                               const Rgb& weight,
                               ColorGradient& d_wi) {
  const SurfacePoint& p = path_->vertices[k].p;
  VertexAdjoint& d = adjoints_[k];
  const BsdfCosines cosines = p.Cosines(wi);
  const BsdfPartials f = EvalBsdfPartials(p.material->bsdf, p.inputs, cosines);
  d.AddScaled(weight, f);
  if (Moves(k)) {
    const Rgb moving = weight * MotionWeight(k);
    const Rgb by_cos_i = moving * (f.d_cos_i + f.value * (1.0 / cosines.cos_i));
    const Rgb by_cos_o = moving * f.d_cos_o;
    const Rgb by_dot = moving * f.d_dot_io;
    d.d_n += Outer(wi, by_cos_i) + Outer(p.wo, by_cos_o);
    d.d_wo += Outer(p.n, by_cos_o) + Outer(wi, by_dot);
    d_wi += Outer(p.n, by_cos_i) + Outer(p.wo, by_dot);
  }
  return f.value;
}

/// Weight of a mirror or glass vertex; returns it.
Rgb PathAdjoint::AdjointOfDeltaWeight(std::size_t k, const Rgb& weight) {
  const Vertex& v = path_->vertices[k];
  VertexAdjoint& d = adjoints_[k];
  const DeltaPartials f = DeltaWeight(v);
  d.AddScaled(weight, f);
  if (Moves(k)) {
    const Rgb by_cos_o = weight * f.d_cos_o * MotionWeight(k);
    d.d_n += Outer(v.p.wo, by_cos_o);
    d.d_wo += Outer(v.p.n, by_cos_o);
  }
  return f.value;
}

Rgb PathAdjoint::AdjointOfDelta(std::size_t k, const Rgb& beyond) {
  const double factor = path_->vertices[k].on.factor;
  return AdjointOfDeltaWeight(k, adjoints_[k].throughput * beyond * factor) * beyond * factor;
}

/// The environment behind a mirror or glass.
Rgb PathAdjoint::AdjointOfEscape(std::size_t k, const DirectContribution& direct) {
  const LightSet::Environment& environment =
      *std::get<const LightSet::Environment*>(direct.light.end);
  const SeenLight& light = direct.light;
  VertexAdjoint& d = adjoints_[k];
  const Rgb value = AdjointOfDeltaWeight(k, d.throughput * light.radiance * direct.factor);
  const Rgb per_radiance = d.throughput * value * direct.factor;
  appearance_.Environment(environment, light.w, per_radiance);
  if (Moves(k)) {
    const ColorGradient d_wi = SkyGradient(environment, light.w, per_radiance * MotionWeight(k));
    d.d_wi += d_wi;
    motion_.LightSpin(environment.emitter, -Cross(light.w, d_wi));
  }
  return value * light.radiance * direct.factor;
}

/// `radiance`: of the whole path.
void PathAdjoint::Scatter(const Rgb& radiance, bool with_first) {
  for (std::size_t k = frozen_; k-- > first_rough_ + 1;) {
    const SurfacePoint& p = path_->vertices[k].p;
    const Vertex& previous = path_->vertices[k - 1];
    const Vec3 start = RayStart(previous.p, previous.on.wi);
    const ColorGradient d_end = EndPointAdjoint(p.wo, Norm(start - p.x), adjoints_[k].d_wo);
    MoveStart(k - 1, d_end);
    adjoints_[k].d_x -= d_end;
    ScatterMaterialPoint(k);
  }
  if (form_ == DerivativeForm::kMaterial && first_rough_ == 0) {
    ScatterCameraVertexInMaterialForm(radiance);
    return;
  }
  for (std::size_t k = with_first ? std::min(first_rough_ + 1, frozen_) : 0; k-- > 0;) {
    ScatterImagePoint(k);
  }
}

/// Adds the adjoint of the place where the ray to the next vertex starts: beside its vertex, with
/// whose normal it turns. Without that what moves as a whole has a derivative of the lift's size.
void PathAdjoint::MoveStart(std::size_t k, const ColorGradient& d) {
  const Vertex& v = path_->vertices[k];
  adjoints_[k].d_x += d;
  adjoints_[k].d_ng += d * RayLift(v.p, v.on.wi);
}

void PathAdjoint::ScatterMaterialPoint(std::size_t k) {
  const Vertex& v = path_->vertices[k];
  const VertexAdjoint& d = adjoints_[k];
  const bool flat = IsFlat(v);
  const ColorGradient d_ng = flat ? d.d_ng + d.d_n : d.d_ng;
  motion_.MaterialPoint(v.p.id, v.p.b1, v.p.b2, d.d_x, d_ng * v.p.side, d.d_log_area);
  if (!flat) {
    ScatterNormals(k);
  }
}

void PathAdjoint::ScatterNormals(std::size_t k) {
  const SurfacePoint& p = path_->vertices[k].p;
  const auto& blocks = active_.meshes[static_cast<std::size_t>(p.id.mesh)];
  if (p.material->normal_texture >= 0) {
    ScatterMappedNormal(k);
    return;
  }
  if (blocks.normals < 0 && blocks.rotation < 0) {
    return;
  }
  const ColorGradient& d_n = adjoints_[k].d_n;
  const Mesh& mesh = world_.mesh(p.id.mesh);
  const Triangle& corners = CornersOf(mesh.normal_triangles, p.id);
  const Vec3 stored = InterpolatedNormal(mesh, p.id, p.b1, p.b2);
  const double norm = Norm(stored);
  const Vec3 n = stored * (p.side / norm);
  const ColorGradient d_m = (d_n - Outer(n, Dot(n, d_n))) * (p.side / norm);
  const std::array<double, 3> weights = {1.0 - p.b1 - p.b2, p.b1, p.b2};
  for (std::size_t i = 0; i < 3; ++i) {
    motion_.VertexNormal(p.id.mesh,
                         corners[i],
                         mesh.normals[static_cast<std::size_t>(corners[i])],
                         d_m * weights[i]);
  }
}

void PathAdjoint::ScatterMappedNormal(std::size_t k) {
  const SurfacePoint& p = path_->vertices[k].p;
  const auto& blocks = active_.meshes[static_cast<std::size_t>(p.id.mesh)];
  const NormalMapPoint at(world_, p.id, p.b1, p.b2);
  const MappedNormal mapped = at.Mapped();
  const ColorGradient& d_n = adjoints_[k].d_n;
  if (!IsFinite(mapped.Value())) return;
  if (blocks.positions < 0 && blocks.normals < 0) {  // all of the frame turns with the pose
    motion_.VertexNormal(p.id.mesh, at.normals[0], mapped.Value(), d_n * p.side);
    return;
  }
  const auto d = mapped.Pull(d_n * p.side);
  const auto add_normal = [&](std::int32_t normal, const ColorGradient& d_m) {
    motion_.VertexNormal(p.id.mesh, normal, at.mesh.normals[static_cast<std::size_t>(normal)], d_m);
  };
  const auto add_position = [&](std::int32_t vertex, const ColorGradient& d_x) {
    motion_.Vertex(p.id.mesh, vertex, at.mesh.positions[static_cast<std::size_t>(vertex)], d_x);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    add_normal(at.normals[i], d.m * at.weights[i]);
    world_.tangents(p.id.mesh).Pull(
        at.mesh, p.id.triangle, i, d.t * at.weights[i], add_position, add_normal);
  }
}

/// A vertex that slides along a ray whose start and direction are known: the sensor's, or that of
/// the mirror or glass vertex before it.  [path_space 1.5, row "image"]
void PathAdjoint::ScatterImagePoint(std::size_t k) {
  const Vertex& v = path_->vertices[k];
  VertexAdjoint& d = adjoints_[k];
  const bool flat = IsFlat(v);
  if (IsDelta(v.p.material->bsdf) && v.continues) {
    PullThroughDelta(k);
    if (!flat) {
      PullThroughMirrorNormal(k);
    }
  }
  const Vec3 w = -v.p.wo;
  const ColorGradient d_label = appearance_.LabelGradient(v, d);
  const ColorGradient d_point = d.d_x + d_label;
  const ColorGradient d_plane = Outer(v.p.ng, Dot(d_point, w) * (1.0 / Dot(v.p.ng, w)));
  motion_.MaterialPoint(v.p.id,
                        v.p.b1,
                        v.p.b2,
                        d_plane - d_label,
                        (flat ? d.d_ng + d.d_n : d.d_ng) * v.p.side,
                        Rgb{});
  if (!flat) {
    ScatterNormals(k);
  }
  const ColorGradient d_origin = d_point - d_plane;
  const auto direction = [&](const Vec3& origin) {
    return d_origin * Norm(v.p.x - origin) - d.d_wo;
  };
  if (k > 0) {
    const Vertex& previous = path_->vertices[k - 1];
    MoveStart(k - 1, d_origin);
    adjoints_[k - 1].d_wi += direction(RayStart(previous.p, previous.on.wi));
  } else if (active_.camera.Any()) {
    motion_.CameraRay(pixel_->ray, pixel_->u, pixel_->v, d_origin, direction(pixel_->ray.origin));
  }
}

/// A mirror's normal is a function of the interpolated one, the facet's and wo.
void PathAdjoint::PullThroughMirrorNormal(std::size_t k) {
  const SurfacePoint& p = path_->vertices[k].p;
  VertexAdjoint& d = adjoints_[k];
  const Vec3 n = SmoothNormal(world_, *p.material, p.id, p.b1, p.b2) * p.side;
  MirrorNormal(n, p.ng, p.wo).Pull(d.d_n, d.d_ng, d.d_wo);
}

/// The next ray's direction is a function of wo and the shading normal (and eta).
void PathAdjoint::PullThroughDelta(std::size_t k) {
  const Vertex& v = path_->vertices[k];
  VertexAdjoint& d = adjoints_[k];
  const double cos_o = Dot(v.p.n, v.p.wo);
  const Rgb along = Dot(v.p.n, d.d_wi);
  if (!v.on.transmit) {  // wi = 2 (n.wo) n - wo
    d.d_wo += Outer(v.p.n, along * 2.0) - d.d_wi;
    d.d_n += d.d_wi * (2.0 * cos_o) + Outer(v.p.wo, along * 2.0);
    return;
  }
  // wi = -eta wo + (eta cos_o - cos_t) n
  const double eta = RelativeEta(v.p.material->bsdf, v.p.inputs);
  const double cos_t = -Dot(v.p.n, v.on.wi);
  const double by_cos_o = eta - eta * eta * cos_o / cos_t;
  d.d_wo += Outer(v.p.n, along * by_cos_o) - d.d_wi * eta;
  d.d_n += d.d_wi * (eta * cos_o - cos_t) + Outer(v.p.wo, along * by_cos_o);
  const double by_eta = cos_o + eta * (1.0 - cos_o * cos_o) / cos_t;
  const Rgb d_eta = along * by_eta - Dot(d.d_wi, v.p.wo);
  // From outside eta = 1 / ior, from inside ior.
  d.d_eta += d_eta * (v.p.inputs.from_inside ? 1.0 : -eta * eta);
}

/// Factors H(u), pixel area per surface area, J of the camera vertex.
void PathAdjoint::ScatterCameraVertexInMaterialForm(const Rgb& radiance) {
  const SurfacePoint& p = path_->vertices[0].p;
  VertexAdjoint& d = adjoints_[0];
  const Rgb value = radiance * pixel_->weight;
  const CameraModel::PixelDensity density = camera_.DensityAt(p.x, p.ng);
  d.d_x += Outer(density.d_x, value);
  d.d_ng += Outer(density.d_n, value);
  d.d_log_area += value;
  const auto projection = camera_.Project(p.x);
  const Rgb d_u = radiance * pixel_->slope_u;
  const Rgb d_v = radiance * pixel_->slope_v;
  if (projection) {
    d.d_x += Outer(projection->du, d_u) + Outer(projection->dv, d_v);
  }
  ColorGradient d_spin;
  ColorGradient d_viewer;
  if (camera_.IsOrthographic()) {
    d_spin = Cross(p.wo, d.d_wo);
  } else {
    d_viewer = EndPointAdjoint(p.wo, Norm(pixel_->ray.origin - p.x), d.d_wo);
    d.d_x -= d_viewer;
  }
  if (active_.camera.Any()) {
    // The density depends on the relative place: moving the sensor is the opposite motion.
    const ColorGradient by_x = Outer(density.d_x, value);
    const ColorGradient by_n = Outer(density.d_n, value);
    motion_.CameraMotion(d_viewer - by_x,
                         d_spin - Cross(p.x - camera_.Origin(), by_x) - Cross(p.ng, by_n));
    std::array<Rgb, CameraModel::kNumIntrinsics> by{};
    for (std::size_t i = 0; i < by.size(); ++i) {
      by[i] = value * density.d_intrinsics[i];
    }
    motion_.Intrinsics(by);
    if (projection) {
      motion_.PixelOfFixedPoint(p.x, *projection, d_u, d_v);
    }
  }
  ScatterMaterialPoint(0);
}

void PathAdjoint::AddMiss(const PixelSample& pixel) {
  const LightSet::Environment& environment = *context_.lights.environment;
  const Vec3& w = pixel.ray.direction;
  appearance_.Environment(environment, w, Rgb::Constant(pixel.weight));
  if (!motion_.LightMoves(environment.emitter) && !active_.camera.Any()) {
    return;
  }
  if (form_ == DerivativeForm::kImage || camera_.IsOrthographic()) {
    const ColorGradient d_w = SkyGradient(environment, w, Rgb::Constant(pixel.weight));
    motion_.LightSpin(environment.emitter, -Cross(w, d_w));
    motion_.CameraRay(pixel.ray, pixel.u, pixel.v, ColorGradient{}, d_w);
    return;
  }
  // The label is a direction that turns with the environment: the radiance stays, the pixel area
  // per solid angle (surface at unit distance that faces the sensor) and the filter change.
  const Rgb radiance = EnvironmentRadianceInWorld(environment, w);
  const Rgb value = radiance * pixel.weight;
  const Vec3 x = pixel.ray.origin + w;
  const CameraModel::PixelDensity density = camera_.DensityAt(x, w);
  const auto projection = camera_.Project(x);
  if (!projection) {
    return;
  }
  const Rgb d_u = radiance * pixel.slope_u;
  const Rgb d_v = radiance * pixel.slope_v;
  const ColorGradient d_w = Outer(density.d_x + density.d_n, value) + Outer(projection->du, d_u) +
                            Outer(projection->dv, d_v);
  motion_.LightSpin(environment.emitter, Cross(w, d_w));
  motion_.CameraMotion(ColorGradient{}, -Cross(w, d_w));
  std::array<Rgb, CameraModel::kNumIntrinsics> d{};
  const auto by = camera_.PixelByIntrinsics(x);
  for (std::size_t i = 0; i < d.size(); ++i) {
    d[i] = value * density.d_intrinsics[i] + d_u * by[i].x + d_v * by[i].y;
  }
  motion_.Intrinsics(d);
}

}  // namespace pathfit::renderer
