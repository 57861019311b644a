#pragma once

#include <cmath>

#include "renderer/geometry/ray_caster.h"
#include "renderer/path/mapped_normal.h"
#include "renderer/path/mirror_normal.h"
#include "renderer/scene/world.h"

namespace pathfit::renderer {

/// A point on a surface as seen from one side.
struct SurfacePoint {
  TriangleId id;
  double b1 = 0.0, b2 = 0.0;
  Vec3 x;
  Vec3 ng;              ///< unit geometric normal, turned to the side of wo
  Vec3 n;               ///< unit shading normal, turned with ng; equal to ng on flat meshes; by the
                        ///< normal map; of mirrors and smooth glass the MirrorNormal
  double side = 1.0;    ///< +1 seen from the front (normal of the winding), -1 from behind
  Vec3 wo;              ///< unit, towards where it is seen from
  double offset = 0.0;  ///< RayCaster::Offset(x)
  BsdfInputs inputs;
  const Material* material = nullptr;

  /// Whether the material scatters on this side at all.
  [[nodiscard]] bool Reflects() const {
    return side > 0.0 || material->two_sided || IsTransmissive(material->bsdf);
  }
  /// Whether light can come from direction wi: shading and geometry must agree on its side.
  [[nodiscard]] bool Accepts(const Vec3& wi) const {
    const double cos_i = Dot(n, wi);
    return cos_i * Dot(ng, wi) > 0.0 && (cos_i > 0.0 || IsTransmissive(material->bsdf));
  }
  [[nodiscard]] BsdfCosines Cosines(const Vec3& wi) const {
    return {Dot(n, wi), Dot(n, wo), Dot(wi, wo)};
  }
};

/// How far along p.ng a ray in direction wi starts: beside the surface, on the side of wi.
inline double RayLift(const SurfacePoint& p, const Vec3& wi) {
  return std::copysign(p.offset, Dot(p.ng, wi));
}
inline Vec3 RayStart(const SurfacePoint& p, const Vec3& wi) { return p.x + p.ng * RayLift(p, wi); }

inline const Triangle& CornersOf(const SharedVector<Triangle>& triangles, TriangleId id) {
  return triangles[static_cast<std::size_t>(id.triangle)];
}
/// Interpolates a list indexed by its own triangles.
template <class T>
T Interpolate(const SharedVector<T>& values, const Triangle& corners, double b1, double b2) {
  return values[static_cast<std::size_t>(corners[0])] * (1.0 - b1 - b2) +
         values[static_cast<std::size_t>(corners[1])] * b1 +
         values[static_cast<std::size_t>(corners[2])] * b2;
}
inline Vec2 UvAt(const Mesh& mesh, TriangleId id, double b1, double b2) {
  return Interpolate(mesh.uvs, CornersOf(mesh.uv_triangles, id), b1, b2);
}

/// Of a mesh that has normals; not yet unit, on the front.
inline Vec3 InterpolatedNormal(const Mesh& mesh, TriangleId id, double b1, double b2) {
  return Interpolate(mesh.normals, CornersOf(mesh.normal_triangles, id), b1, b2);
}

/// What a mirror bends: interpolated or by the normal map; unit, on the front. Not finite where
/// neither tells a direction.
inline Vec3 SmoothNormal(
    const World& world, const Material& material, TriangleId id, double b1, double b2) {
  if (material.normal_texture >= 0) {
    const Vec3 n = MappedNormalAt(world, id, b1, b2);
    if (IsFinite(n)) return n;
  }
  return Normalized(InterpolatedNormal(world.mesh(id.mesh), id, b1, b2));
}

/// Constants of the rough models.
inline void ReadModelConstants(const Bsdf& bsdf, BsdfInputs& inputs) {
  if (const auto* m = std::get_if<MetallicRoughnessBsdf>(&bsdf)) {
    inputs.roughness = m->roughness;
    inputs.metallic = m->metallic;
  } else if (const auto* conductor = std::get_if<RoughConductorBsdf>(&bsdf)) {
    inputs.roughness = conductor->roughness;
  } else if (const auto* dielectric = std::get_if<RoughDielectricBsdf>(&bsdf)) {
    inputs.roughness = dielectric->roughness;
  }
}

/// What the BSDF needs to know at a point of a mesh.
inline BsdfInputs InputsAt(const Scene& scene,
                           const Mesh& mesh,
                           const Material& material,
                           TriangleId id,
                           double b1,
                           double b2) {
  BsdfInputs inputs;
  ReadModelConstants(material.bsdf, inputs);
  inputs.base_color = material.vertex_colors
                          ? Interpolate(mesh.colors, CornersOf(mesh.color_triangles, id), b1, b2)
                          : material.base_color;
  const auto texture = [&](int index) {
    return TextureValue(scene.textures[static_cast<std::size_t>(index)], UvAt(mesh, id, b1, b2));
  };
  if (material.base_color_texture >= 0) inputs.base_color = texture(material.base_color_texture);
  if (material.roughness_texture >= 0) {
    inputs.roughness = std::max(kMinRoughness, texture(material.roughness_texture).r);
  }
  if (material.metallic_texture >= 0) inputs.metallic = texture(material.metallic_texture).r;
  return inputs;
}

/// A point of the world at given barycentrics, seen along unit direction -wo.
inline SurfacePoint MakeSurfacePoint(
    const World& world, TriangleId id, double b1, double b2, const Vec3& x, const Vec3& wo) {
  const TriangleGeometry& triangle = world.caster().Geometry(id);
  const Mesh& mesh = world.mesh(id.mesh);
  SurfacePoint p;
  p.material = &world.MaterialOf(id.mesh);
  p.id = id;
  p.b1 = b1;
  p.b2 = b2;
  p.x = x;
  p.wo = wo;
  p.offset = world.caster().Offset(x);
  p.side = Dot(triangle.n, wo) >= 0.0 ? 1.0 : -1.0;
  p.ng = triangle.n * p.side;
  p.n = p.ng;
  if (!mesh.normal_triangles.empty()) {
    const Vec3 m = SmoothNormal(world, *p.material, id, b1, b2) * p.side;
    p.n = IsFinite(m) ? m : p.ng;
    if (IsDelta(p.material->bsdf)) {
      p.n = MirrorNormal(p.n, p.ng, wo).Value();
    }
  }
  p.inputs = InputsAt(world.scene(), mesh, *p.material, id, b1, b2);
  p.inputs.from_inside = p.side < 0.0;
  return p;
}

inline SurfacePoint MakeSurfacePoint(const World& world, const Hit& hit, const Ray& ray) {
  return MakeSurfacePoint(
      world, hit.id, hit.b1, hit.b2, ray.origin + ray.direction * hit.distance, -ray.direction);
}

}  // namespace pathfit::renderer
