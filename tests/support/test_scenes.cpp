#include "tests/support/test_scenes.h"

#include <cmath>

#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/mesh_primitives.h"

namespace pathfit::tests {

using renderer::Mesh;
using renderer::Rgb;
using renderer::Vec2;
using renderer::Vec3;

Mesh Rectangle() { return renderer::MakeRectangle(); }
Mesh Cube() { return renderer::MakeCube(); }

renderer::Camera CameraAt(
    const Vec3& origin, const Vec3& target, double focal_px, int width, int height) {
  renderer::Camera camera;
  camera.name = "camera";
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = focal_px;
  camera.cx = 0.5 * width;
  camera.cy = 0.5 * height;
  const Vec3 up = std::abs(origin.x - target.x) + std::abs(origin.z - target.z) > 0.0
                      ? Vec3{0, 1, 0}
                      : Vec3{0, 0, -1};
  camera.world_from_camera = renderer::LookAt(origin, target, up);
  return camera;
}

renderer::Emitter GradientEnvironment(int width, int height) {
  renderer::EnvironmentEmitter environment;
  environment.width = width;
  environment.height = height;
  environment.texels.clear();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = 6.283185307179586 * (x + 0.5) / width;
      const double v = 3.141592653589793 * (y + 0.5) / height;
      environment.texels.push_back({1.0 + 0.6 * std::cos(u),
                                    0.8 + 0.5 * std::cos(v),
                                    1.1 + 0.7 * std::sin(u) * std::sin(v)});
    }
  }
  return {"sky", renderer::LightFrame::kWorld, {}, environment};
}

renderer::Emitter ConstantEnvironment(const Rgb& radiance) {
  renderer::EnvironmentEmitter environment;
  environment.texels = {radiance};
  return {"sky", renderer::LightFrame::kWorld, {}, environment};
}

renderer::Scene BallAndWall() {
  renderer::Scene scene;
  Mesh ball = renderer::MakeIcosphere(1, 0.8);
  for (std::size_t i = 0; i < ball.positions.size(); ++i) {
    const double s = static_cast<double>(i);
    ball.colors.push_back(
        {0.5 + 0.4 * std::sin(s), 0.5 + 0.4 * std::cos(1.7 * s), 0.5 + 0.3 * std::sin(2.3 * s)});
  }
  ball.color_triangles = ball.triangles;
  Mesh wall = Rectangle();
  renderer::ApplyTransform({{{1.6, 0.3, 0.2}, {0, 1.5, 0.4}, {-0.2, -0.3, 1}}, {0.1, 0.2, -1.5}},
                           wall);
  renderer::Material diffuse{"paint", renderer::LambertBsdf{}, {0.5, 0.5, 0.5}, true};
  renderer::Material gloss{"gloss", renderer::MetallicRoughnessBsdf{0.45, 0.6}, {0.7, 0.5, 0.3}};
  scene.materials = {diffuse, gloss};
  scene.meshes = {{"ball", ball, 0, {}}, {"wall", wall, 1, {}}};
  scene.emitters = {
      GradientEnvironment(8, 4),
      {"lamp",
       renderer::LightFrame::kWorld,
       {},
       renderer::PointEmitter{{1.5, 2.0, 2.5}, {4.0, 3.0, 2.0}}},
      {"sun",
       renderer::LightFrame::kCamera,
       {},
       renderer::DirectionalEmitter{renderer::Normalized(Vec3{0.3, -0.4, -1.0}), {0.6, 0.7, 0.8}}}};
  scene.sensors = {CameraAt({0.2, 0.3, 4.0}, {0, 0, 0}, 28.0, 24, 24)};
  return scene;
}

namespace {

/// Directions that turn by about `tilt` rad, other ones in each texel.
renderer::Texture Bumps(double tilt, int size = 8) {
  renderer::Texture texture;
  texture.name = "bumps";
  texture.width = texture.height = size;
  texture.texels.clear();
  for (int i = 0; i < size * size; ++i) {
    const double x = tilt * std::sin(2.4 * i), y = tilt * std::cos(3.7 * i);
    const Vec3 n = renderer::Normalized(Vec3{x, y, 1.0});
    texture.texels.push_back({0.5 + 0.5 * n.x, 0.5 + 0.5 * n.y, 0.5 + 0.5 * n.z});
  }
  return texture;
}

/// A wavy square over [-1, 1]^2 facing +z, smooth, with crooked UVs.
Mesh WavyMesh(int cells) {
  Mesh mesh;
  for (int y = 0; y <= cells; ++y) {
    for (int x = 0; x <= cells; ++x) {
      const double a = 2.0 * x / cells - 1.0, b = 2.0 * y / cells - 1.0;
      mesh.positions.push_back({a, b, 0.1 * std::sin(2.0 * a + b)});
      mesh.uvs.push_back({0.1 + 0.35 * (a + 1.0) + 0.06 * b * b, 0.1 + 0.3 * (b + 1.0) + 0.05 * a});
    }
  }
  for (std::int32_t y = 0; y < cells; ++y) {
    for (std::int32_t x = 0; x < cells; ++x) {
      const std::int32_t i = y * (cells + 1) + x;
      mesh.triangles.push_back({i, i + 1, i + cells + 2});
      mesh.triangles.push_back({i, i + cells + 2, i + cells + 1});
    }
  }
  mesh.uv_triangles = mesh.triangles;
  renderer::ComputeVertexNormals(mesh);
  return mesh;
}

}  // namespace

renderer::Scene Waves() {
  renderer::Scene scene;
  scene.meshes = {{"object", WavyMesh(4), 0, {}}};
  scene.materials = {{"paint",
                      renderer::MetallicRoughnessBsdf{.roughness = 0.4, .metallic = 0.3},
                      {0.6, 0.4, 0.2}}};
  scene.emitters = {
      {"sun",
       renderer::LightFrame::kWorld,
       {},
       renderer::DirectionalEmitter{renderer::Normalized(Vec3{0.4, 0.3, -1.0}), {2.0, 1.5, 1.0}}}};
  scene.textures = {Bumps(0.3)};
  scene.materials[0].normal_texture = 0;
  scene.materials[0].normal_scale = 0.7;
  return scene;
}

}  // namespace pathfit::tests
