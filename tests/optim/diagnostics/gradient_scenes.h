#pragma once

#include <cmath>
#include <utility>

#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/mesh_primitives.h"
#include "tests/support/probe.h"

// Parts of the small scenes whose derivatives are compared with finite differences.
namespace pathfit::tests {

using renderer::Mesh;
using renderer::Rgb;
using renderer::Scene;
using renderer::Vec3;

/// Turned by a rotation vector, then scaled and moved.
inline Mesh Placed(Mesh mesh, double scale, const Vec3& translation, const Vec3& rotation = {}) {
  renderer::ApplyTransform({renderer::RotationFromVector(rotation), {0, 0, 0}}, mesh);
  renderer::ApplyTransform({{{scale, 0, 0}, {0, scale, 0}, {0, 0, scale}}, translation}, mesh);
  return mesh;
}
/// [-half, half]^2 in the plane y = `height`, facing up.
inline Mesh Floor(double half, double height = 0.0) {
  return Placed(renderer::MakeRectangle(), half, {0, height, 0}, {-0.5 * std::numbers::pi, 0, 0});
}
/// The same, facing down.
inline Mesh Ceiling(double half, const Vec3& at) {
  return Placed(renderer::MakeRectangle(), half, at, {0.5 * std::numbers::pi, 0, 0});
}
inline Mesh Ball(double radius, const Vec3& at, bool smooth, int subdivisions = 1) {
  Mesh mesh = Placed(renderer::MakeIcosphere(subdivisions, radius), 1.0, at);
  if (smooth) renderer::ComputeVertexNormals(mesh);
  return mesh;
}
/// Outside becomes inside.
inline Mesh Inverted(Mesh mesh) {
  for (renderer::Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

/// Texels that differ, in [low, high].
inline renderer::Texture Pattern(
    const std::string& name, int width, int height, double low, double high, bool scalar = false) {
  renderer::Texture texture{name, width, height, {}, renderer::TextureWrap::kClamp, scalar};
  const double middle = 0.5 * (low + high);
  const double swing = 0.5 * (high - low);
  for (int i = 0; i < width * height; ++i) {
    const Rgb wave{std::sin(2.1 * i), std::cos(3.7 * i + 1.0), std::sin(5.3 * i + 2.0)};
    texture.texels.push_back(Rgb::Constant(middle) +
                             (scalar ? Rgb::Constant(wave.r) : wave) * swing);
  }
  return texture;
}
/// Black at its border, so that a projected picture ends without an edge.
inline renderer::Texture Slide(const std::string& name, int size) {
  renderer::Texture texture = Pattern(name, size, size, 0.2, 1.0);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      if (x == 0 || y == 0 || x == size - 1 || y == size - 1) {
        texture.texels[static_cast<std::size_t>(y * size + x)] = {};
      }
    }
  }
  return texture;
}

/// Rotation of a light that looks from one point to another.
inline renderer::Mat3 Aim(const Vec3& from, const Vec3& to) {
  return renderer::LookAt(from, to, {0, 1, 0}).linear;
}
inline renderer::Emitter Lamp(const Vec3& position, const Rgb& intensity) {
  return {"lamp", renderer::LightFrame::kWorld, {}, renderer::PointEmitter{position, intensity}};
}
inline renderer::Emitter Sun(const Vec3& direction, const Rgb& irradiance) {
  return {"sun",
          renderer::LightFrame::kWorld,
          {},
          renderer::DirectionalEmitter{renderer::Normalized(direction), irradiance}};
}
inline renderer::Emitter Spot(const Vec3& from, const Vec3& to, const Rgb& intensity) {
  return {"spot",
          renderer::LightFrame::kWorld,
          {},
          renderer::SpotEmitter{from, Aim(from, to), intensity, 0.15, 0.5}};
}
inline renderer::Emitter Projector(const Vec3& from,
                                   const Vec3& to,
                                   const Rgb& intensity,
                                   int texture) {
  return {"projector",
          renderer::LightFrame::kWorld,
          {},
          renderer::ProjectorEmitter{from, Aim(from, to), 0.45, 0.45, intensity, texture}};
}
inline renderer::Emitter Panel(int mesh, const Rgb& radiance, int texture = -1) {
  renderer::AreaEmitter light;
  light.mesh = mesh;
  light.intensity = radiance;
  light.texture = texture;
  return {"panel", renderer::LightFrame::kWorld, {}, light};
}

/// One thing (mesh 1, material 1) above a floor (mesh 0), seen obliquely, under one lamp.
inline Scene Above(const Mesh& thing, double floor_height = 0.0) {
  Scene scene;
  scene.materials = {{"floor", renderer::LambertBsdf{}, {0.8, 0.7, 0.6}},
                     {"thing", renderer::LambertBsdf{}, {0.5, 0.7, 0.9}}};
  scene.meshes = {{"floor", Floor(3.0, floor_height), 0, {}}, {"thing", thing, 1, {}}};
  scene.emitters = {Lamp({1.0, 3.0, 0.8}, {9, 8, 7})};
  scene.sensors = {CameraAt({0.6, 2.6, 3.4}, {0.0, 0.45, 0}, 24.0, 16, 16)};
  // Tilted: an edge along a row of pixels would cross the border of a tile as a whole.
  scene.sensors[0].rotation = {0.0, 0.0, 0.2};
  return scene;
}
/// The same under a square light (mesh 2) as well.
inline Scene AboveUnderPanel(const Mesh& thing) {
  Scene scene = Above(thing);
  scene.materials.push_back({"black", renderer::LambertBsdf{}, {0, 0, 0}});
  scene.meshes.push_back({"panel", Ceiling(0.5, {-0.3, 2.6, 0.2}), 2, {}});
  scene.emitters.push_back(Panel(2, {6, 6, 6}));
  return scene;
}

}  // namespace pathfit::tests
