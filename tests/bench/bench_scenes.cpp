#include "tests/bench/bench_scenes.h"

#include <algorithm>
#include <cmath>

#include "tests/support/test_scenes.h"

namespace pathfit::bench {

using renderer::Mesh;
using renderer::Rgb;
using renderer::Transform;
using renderer::Vec3;

namespace {

Mesh Placed(Mesh mesh, const Transform& world_from_object) {
  renderer::ApplyTransform(world_from_object, mesh);
  return mesh;
}

Transform Block(const Vec3& half, const Vec3& center, double angle) {
  const renderer::Mat3 turn = renderer::RotationAboutAxis({0, 1, 0}, angle);
  return {{turn.x * half.x, turn.y * half.y, turn.z * half.z}, center};
}

Mesh BumpyBall() {
  Mesh ball = renderer::MakeIcosphere(6, 1.0);
  for (Vec3& p : ball.positions) {
    p = p * (1.0 + 0.05 * std::sin(9.0 * p.x) * std::sin(8.0 * p.y) * std::sin(7.0 * p.z));
  }
  return ball;
}

renderer::Material Diffuse(const char* name, const Rgb& color) {
  renderer::Material material;
  material.name = name;
  material.bsdf = renderer::LambertBsdf{};
  material.base_color = color;
  return material;
}

}  // namespace

renderer::Scene BoxScene() {
  renderer::Scene scene;
  scene.materials = {Diffuse("white", {0.75, 0.75, 0.75}),
                     Diffuse("red", {0.6, 0.1, 0.1}),
                     Diffuse("green", {0.1, 0.5, 0.1})};
  const double right_angle = 1.5707963267948966;
  const Mesh wall = tests::Rectangle();
  const auto turned = [&](const Vec3& axis, double angle, const Vec3& center) {
    return Placed(wall, {renderer::RotationAboutAxis(axis, angle), center});
  };
  scene.meshes = {
      {"back", Placed(wall, {{}, {0, 0, -1}}), 0, {}},
      {"floor", turned({1, 0, 0}, -right_angle, {0, -1, 0}), 0, {}},
      {"ceiling", turned({1, 0, 0}, right_angle, {0, 1, 0}), 0, {}},
      {"left", turned({0, 1, 0}, right_angle, {-1, 0, 0}), 1, {}},
      {"right", turned({0, 1, 0}, -right_angle, {1, 0, 0}), 2, {}},
      {"low", Placed(tests::Cube(), Block({0.3, 0.3, 0.3}, {0.35, -0.699, 0.3}, 0.3)), 0, {}},
      {"high", Placed(tests::Cube(), Block({0.3, 0.6, 0.3}, {-0.35, -0.399, -0.3}, -0.3)), 0, {}}};
  scene.emitters = {{"lamp",
                     renderer::LightFrame::kWorld,
                     {},
                     renderer::PointEmitter{{0.0, 0.9, 0.0}, {1.0, 0.9, 0.8}}}};
  scene.sensors = {tests::CameraAt({0, 0, 3.9}, {0, 0, 0}, 180.0, 128, 128)};
  return scene;
}

renderer::Scene MeshOnFloorScene(const Mesh& mesh) {
  renderer::Scene scene;
  Mesh object = mesh.triangles.empty() ? BumpyBall() : mesh;
  Vec3 low{1e300, 1e300, 1e300};
  Vec3 high = -low;
  for (const Vec3& p : object.positions) {
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  }
  const double scale = 2.0 / std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  const Vec3 center = (low + high) * 0.5;
  for (Vec3& p : object.positions) {
    p = (p - center) * scale;
  }
  const double floor_height = 0.5 * (low.y - high.y) * scale;
  renderer::SetUniformVertexColors({0.6, 0.5, 0.4}, object);
  scene.materials = {Diffuse("object", {0.5, 0.5, 0.5}), Diffuse("floor", {0.5, 0.5, 0.5})};
  scene.materials.front().vertex_colors = true;
  const renderer::Mat3 lie = renderer::RotationAboutAxis({1, 0, 0}, -1.5707963267948966);
  const Mesh floor =
      Placed(tests::Rectangle(), {{lie.x * 3.0, lie.y * 3.0, lie.z}, {0, floor_height, 0}});
  scene.meshes = {{"object", object, 0, {}}, {"floor", floor, 1, {}}};
  scene.emitters = {tests::ConstantEnvironment({1.0, 1.0, 1.0})};
  scene.sensors = {tests::CameraAt({0.0, 0.8, 4.5}, {0, 0, 0}, 200.0, 128, 128)};
  return scene;
}

}  // namespace pathfit::bench
