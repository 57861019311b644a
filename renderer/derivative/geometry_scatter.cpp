#include "renderer/derivative/geometry_scatter.h"

namespace pathfit::renderer {

void GeometryScatter::Run(const Rgb& radiance, std::size_t first_rough, std::size_t end) {
  for (std::size_t k = end; k-- > first_rough + 1;) {
    Vertex& v = vertices_[k];
    Vertex& previous = vertices_[k - 1];
    const Vec3 start = RayStart(context_.world->caster(), previous.p, previous.on.wi);
    const ColorGradient d_end = EndPointAdjoint(v.p.wo, Norm(start - v.p.x), v.d_wo);
    MoveStart(context_.world->caster(), previous, d_end);
    v.d_x -= d_end;
    ScatterMaterialPoint(v);
  }
  if (form_ == DerivativeForm::kMaterial && first_rough == 0) {
    ScatterCameraVertexInMaterialForm(radiance);
    return;
  }
  for (std::size_t k = std::min(first_rough + 1, end); k-- > 0;) {
    ScatterImagePoint(k);
  }
}

void GeometryScatter::ScatterMaterialPoint(const Vertex& v) {
  const bool flat = FlatMesh(v);
  const ColorGradient d_ng = flat ? v.d_ng + v.d_n : v.d_ng;
  motion_.MaterialPoint(v.p.id, v.p.b1, v.p.b2, v.d_x, d_ng * v.p.side, v.d_log_area);
  if (!flat) {
    ScatterNormals(v);
  }
}

bool GeometryScatter::FlatMesh(const Vertex& v) const {
  return context_.world->mesh(v.p.id.mesh).normal_triangles.empty();
}

void GeometryScatter::ScatterNormals(const Vertex& v) {
  const auto& blocks = active_.meshes[static_cast<std::size_t>(v.p.id.mesh)];
  if (blocks.normals < 0 && blocks.rotation < 0) {
    return;
  }
  const Mesh& mesh = context_.world->mesh(v.p.id.mesh);
  const Triangle& corners = CornersOf(mesh.normal_triangles, v.p.id);
  const Vec3 stored = InterpolatedNormal(mesh, v.p.id, v.p.b1, v.p.b2);
  const double norm = Norm(stored);
  const Vec3 n = stored * (v.p.side / norm);
  const ColorGradient d_m = (v.d_n - Outer(n, Dot(n, v.d_n))) * (v.p.side / norm);
  const std::array<double, 3> weights = {1.0 - v.p.b1 - v.p.b2, v.p.b1, v.p.b2};
  for (std::size_t i = 0; i < 3; ++i) {
    motion_.VertexNormal(v.p.id.mesh,
                         corners[i],
                         mesh.normals[static_cast<std::size_t>(corners[i])],
                         d_m * weights[i]);
  }
}

/// A vertex that slides along a ray whose start and direction are known: the sensor's, or that of
/// the mirror or glass vertex before it.  [path_space 1.5, row "image"]
void GeometryScatter::ScatterImagePoint(std::size_t k) {
  const Vertex& v = vertices_[k];
  if (IsDelta(v.p.material->bsdf) && v.continues) {
    PullThroughDelta(vertices_[k]);
    if (!FlatMesh(v)) {
      PullThroughMirrorNormal(vertices_[k]);
    }
  }
  const Vec3 w = -v.p.wo;
  const ColorGradient d_label = appearance_.LabelGradient(v);
  const ColorGradient d_point = v.d_x + d_label;
  const ColorGradient d_plane = Outer(v.p.ng, Dot(d_point, w) * (1.0 / Dot(v.p.ng, w)));
  const bool flat = FlatMesh(v);
  motion_.MaterialPoint(v.p.id,
                        v.p.b1,
                        v.p.b2,
                        d_plane - d_label,
                        (flat ? v.d_ng + v.d_n : v.d_ng) * v.p.side,
                        Rgb{});
  if (!flat) {
    ScatterNormals(v);
  }
  const ColorGradient d_origin = d_point - d_plane;
  const Vec3 origin =
      k == 0 ? pixel_.ray.origin
             : RayStart(context_.world->caster(), vertices_[k - 1].p, vertices_[k - 1].on.wi);
  const ColorGradient d_direction = d_origin * Norm(v.p.x - origin) - v.d_wo;
  if (k > 0) {
    MoveStart(context_.world->caster(), vertices_[k - 1], d_origin);
    vertices_[k - 1].d_wi += d_direction;
  } else if (active_.camera.Any()) {
    motion_.CameraRay(pixel_.ray, pixel_.u, pixel_.v, d_origin, d_direction);
  }
}

/// A mirror's normal is a function of the interpolated one, the facet's and wo.
void GeometryScatter::PullThroughMirrorNormal(Vertex& v) const {
  const Mesh& mesh = context_.world->mesh(v.p.id.mesh);
  const Vec3 n = Normalized(InterpolatedNormal(mesh, v.p.id, v.p.b1, v.p.b2)) * v.p.side;
  MirrorNormal(n, v.p.ng, v.p.wo).Pull(v.d_n, v.d_ng, v.d_wo);
}

/// The next ray's direction is a function of wo and the shading normal (and eta).
void GeometryScatter::PullThroughDelta(Vertex& v) {
  const double cos_o = Dot(v.p.n, v.p.wo);
  const Rgb along = Dot(v.p.n, v.d_wi);
  if (!v.on.transmit) {  // wi = 2 (n.wo) n - wo
    v.d_wo += Outer(v.p.n, along * 2.0) - v.d_wi;
    v.d_n += v.d_wi * (2.0 * cos_o) + Outer(v.p.wo, along * 2.0);
    return;
  }
  // wi = -eta wo + (eta cos_o - cos_t) n
  const double eta = RelativeEta(v.p.material->bsdf, v.p.inputs);
  const double cos_t = -Dot(v.p.n, v.on.wi);
  const double by_cos_o = eta - eta * eta * cos_o / cos_t;
  v.d_wo += Outer(v.p.n, along * by_cos_o) - v.d_wi * eta;
  v.d_n += v.d_wi * (eta * cos_o - cos_t) + Outer(v.p.wo, along * by_cos_o);
  const double by_eta = cos_o + eta * (1.0 - cos_o * cos_o) / cos_t;
  const Rgb d_eta = along * by_eta - Dot(v.d_wi, v.p.wo);
  // From outside eta = 1 / ior, from inside ior.
  v.d_eta += d_eta * (v.p.inputs.from_inside ? 1.0 : -eta * eta);
}

/// Factors H(u), pixel area per surface area, J of the camera vertex.
void GeometryScatter::ScatterCameraVertexInMaterialForm(const Rgb& radiance) {
  Vertex& v = vertices_[0];
  const Rgb value = radiance * pixel_.weight;
  const CameraModel::PixelDensity density = camera_.DensityAt(v.p.x, v.p.ng);
  v.d_x += Outer(density.d_x, value);
  v.d_ng += Outer(density.d_n, value);
  v.d_log_area += value;
  const auto projection = camera_.Project(v.p.x);
  const Rgb d_u = radiance * pixel_.slope_u;
  const Rgb d_v = radiance * pixel_.slope_v;
  if (projection) {
    v.d_x += Outer(projection->du, d_u) + Outer(projection->dv, d_v);
  }
  ColorGradient d_spin;
  ColorGradient d_viewer;
  if (camera_.IsOrthographic()) {
    d_spin = Cross(v.p.wo, v.d_wo);
  } else {
    d_viewer = EndPointAdjoint(v.p.wo, Norm(pixel_.ray.origin - v.p.x), v.d_wo);
    v.d_x -= d_viewer;
  }
  if (active_.camera.Any()) {
    // The density depends on the relative place: moving the sensor is the opposite motion.
    const ColorGradient by_x = Outer(density.d_x, value);
    const ColorGradient by_n = Outer(density.d_n, value);
    motion_.CameraMotion(d_viewer - by_x,
                         d_spin - Cross(v.p.x - camera_.Origin(), by_x) - Cross(v.p.ng, by_n));
    std::array<Rgb, CameraModel::kNumIntrinsics> d{};
    for (std::size_t i = 0; i < d.size(); ++i) {
      d[i] = value * density.d_intrinsics[i];
    }
    motion_.Intrinsics(d);
    if (projection) {
      motion_.PixelOfFixedPoint(v.p.x, *projection, d_u, d_v);
    }
  }
  ScatterMaterialPoint(v);
}

}  // namespace pathfit::renderer
