#pragma once

#include "renderer/geometry/ray_caster.h"
#include "renderer/scene/scene.h"

namespace pathfit::renderer {

/// A point on a surface as seen from one side.
struct SurfacePoint {
  TriangleId id;
  double b1 = 0.0, b2 = 0.0;
  Vec3 x;
  Vec3 n;             ///< unit geometric normal, turned to the side of wo
  double side = 1.0;  ///< +1 seen from the front (normal of the winding), -1 from behind
  Vec3 wo;            ///< unit, towards where it is seen from
  Rgb base_color;
  const Material* material = nullptr;

  /// Whether the material reflects on this side at all.
  [[nodiscard]] bool Reflects() const { return side > 0.0 || material->two_sided; }
};

/// `viewer` is where the point is seen from.
inline SurfacePoint MakeSurfacePoint(const Scene& scene,
                                     const RayCaster& caster,
                                     const Hit& hit,
                                     const Ray& ray) {
  const TriangleGeometry& triangle = caster.Geometry(hit.id);
  const SceneMesh& mesh = scene.meshes[static_cast<std::size_t>(hit.id.mesh)];
  SurfacePoint p;
  p.id = hit.id;
  p.b1 = hit.b1;
  p.b2 = hit.b2;
  p.x = ray.origin + ray.direction * hit.distance;
  p.wo = -ray.direction;
  p.side = Dot(triangle.n, p.wo) >= 0.0 ? 1.0 : -1.0;
  p.n = triangle.n * p.side;
  p.material = &scene.materials[static_cast<std::size_t>(mesh.material)];
  if (p.material->vertex_colors) {
    const Triangle& t = mesh.mesh.color_triangles[static_cast<std::size_t>(hit.id.triangle)];
    const auto color = [&](std::size_t i) {
      return mesh.mesh.colors[static_cast<std::size_t>(t[i])];
    };
    p.base_color = color(0) * (1.0 - p.b1 - p.b2) + color(1) * p.b1 + color(2) * p.b2;
  } else {
    p.base_color = p.material->base_color;
  }
  return p;
}

}  // namespace pathfit::renderer
