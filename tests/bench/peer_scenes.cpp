#include "tests/bench/peer_scenes.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "renderer/geometry/mesh_normals.h"
#include "renderer/geometry/mesh_repair.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/mesh_file.h"

namespace pathfit::bench {

using renderer::Mesh;
using renderer::Rgb;
using renderer::Scene;
using renderer::Transform;
using renderer::Vec3;

namespace {

constexpr int kSize = 128;
constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
constexpr Rgb kGray{0.5, 0.5, 0.5};
constexpr Rgb kBlack{0.0, 0.0, 0.0};

enum class Shading { kFlat, kSmooth };

/// Scale, then rotation about an axis by degrees, then translation.
Transform Place(const Vec3& translation,
                const Vec3& scale = {1.0, 1.0, 1.0},
                const Vec3& axis = {0.0, 1.0, 0.0},
                double degrees = 0.0) {
  const renderer::Mat3 turn = renderer::RotationAboutAxis(axis, degrees * kRadiansPerDegree);
  return {{turn.x * scale.x, turn.y * scale.y, turn.z * scale.z}, translation};
}

/// Field of view along the smaller side, equal here.
renderer::Camera CameraAt(const Vec3& origin, const Vec3& target, double degrees) {
  renderer::Camera camera;
  camera.name = "sensor";
  camera.width = kSize;
  camera.height = kSize;
  camera.fx = 0.5 * kSize / std::tan(0.5 * degrees * kRadiansPerDegree);
  camera.fy = camera.fx;
  camera.cx = 0.5 * kSize;
  camera.cy = 0.5 * kSize;
  camera.world_from_camera = renderer::LookAt(origin, target, {0.0, 1.0, 0.0});
  return camera;
}

class SceneBuilder {
 public:
  explicit SceneBuilder(std::filesystem::path meshes) : meshes_(std::move(meshes)) {}

  /// Adds a mesh with its own diffuse material and returns its index. Smooth meshes without normals
  /// get the mean of their triangles' weighted by angle, which is what the peer does.
  int Add(const char* name,
          const char* file,
          const Rgb& color,
          const Transform& world_from_object,
          Shading shading = Shading::kSmooth) {
    Mesh mesh = renderer::RepairMesh(renderer::ReadMesh(meshes_ / file), file);
    if (shading == Shading::kFlat) {
      renderer::RemoveVertexNormals(mesh);
    } else if (mesh.normal_triangles.empty()) {
      renderer::ComputeVertexNormals(mesh);
    }
    renderer::ApplyTransform(world_from_object, mesh);
    const int index = static_cast<int>(scene.meshes.size());
    renderer::Material material;
    material.name = name;
    material.bsdf = renderer::LambertBsdf{};
    material.base_color = color;
    material.two_sided = false;
    scene.materials.push_back(material);
    scene.meshes.push_back({name, std::move(mesh), index, {}});
    return index;
  }
  void AddAreaLight(int mesh, const Rgb& radiance) {
    scene.emitters.push_back({scene.meshes[static_cast<std::size_t>(mesh)].name,
                              renderer::LightFrame::kWorld,
                              {},
                              renderer::AreaEmitter{mesh, radiance, -1, false}});
  }
  void AddEnvironment(const char* file) {
    const renderer::Image image = renderer::ReadExr(meshes_ / file);
    renderer::EnvironmentEmitter environment;
    environment.width = image.width;
    environment.height = image.height;
    environment.texels.clear();
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        environment.texels.push_back(image.ColorAt(x, y));
      }
    }
    scene.emitters.push_back(
        {"environment", renderer::LightFrame::kWorld, {}, std::move(environment)});
  }

  Scene scene;

 private:
  std::filesystem::path meshes_;
};

/// A ball outside the view throws a soft shadow on a wall.
PeerCase SoftShadow(SceneBuilder builder) {
  builder.Add(
      "wall", "rectangle.obj", kGray, Place({0.0, 0.0, 0.0}, {2.0, 2.0, 2.0}), Shading::kFlat);
  PeerCase result;
  result.mover = builder.Add("mover", "sphere.obj", kGray, Place({1.4, 0.2, 1.6}, {0.3, 0.3, 0.3}));
  builder.AddAreaLight(
      builder.Add("light", "sphere.obj", kBlack, Place({3.0, 0.4, 3.4}, {0.15, 0.15, 0.15})),
      {100.0, 100.0, 100.0});
  builder.scene.sensors = {CameraAt({0.0, 0.0, 4.0}, {0.0, 0.0, 0.0}, 28.0)};
  result.scene = std::move(builder.scene);
  result.direction = {1.0, 0.0, 0.0};
  return result;
}

enum class Sky { kMap, kConstant };

/// The bunny above a floor under the sky.
PeerCase Bunny(SceneBuilder builder, int max_bounces, Sky sky) {
  builder.Add("floor",
              "rectangle.obj",
              kGray,
              Place({0.0, -0.55, 0.0}, {2.0, 2.0, 2.0}, {1.0, 0.0, 0.0}, -90.0),
              Shading::kFlat);
  PeerCase result;
  result.mover =
      builder.Add("mover", "bunny.ply", {0.6, 0.5, 0.4}, Place({0.0, -0.2, 0.0}, {6.5, 6.5, 6.5}));
  if (sky == Sky::kMap) {
    builder.AddEnvironment("envmap2.exr");
  } else {
    builder.scene.emitters.push_back(
        {"environment", renderer::LightFrame::kWorld, {}, renderer::EnvironmentEmitter{}});
  }
  builder.scene.sensors = {CameraAt({0.0, 0.6, 3.2}, {0.0, 0.0, 0.0}, 40.0)};
  result.scene = std::move(builder.scene);
  result.max_bounces = max_bounces;
  result.kind = renderer::ParameterKind::kObjectRotation;
  result.direction = {0.0, kRadiansPerDegree, 0.0};
  result.finite_difference_step = 1e-1;
  return result;
}

/// Box with two blocks, the lower one moves.
PeerCase CornellFourBounces(SceneBuilder builder) {
  const Rgb white{0.885809, 0.698859, 0.666422};
  const Transform identity;
  builder.Add("floor", "cbox_floor.obj", white, identity, Shading::kFlat);
  builder.Add("ceiling", "cbox_ceiling.obj", white, identity, Shading::kFlat);
  builder.Add("back", "cbox_back.obj", white, identity, Shading::kFlat);
  builder.Add(
      "greenwall", "cbox_greenwall.obj", {0.105421, 0.37798, 0.076425}, identity, Shading::kFlat);
  builder.Add(
      "redwall", "cbox_redwall.obj", {0.570068, 0.0430135, 0.0443706}, identity, Shading::kFlat);
  const Vec3 up{0.0, 1.0, 0.0};
  PeerCase result;
  result.mover = builder.Add("mover",
                             "box.obj",
                             white,
                             Place({0.35, -0.68, 0.3}, {0.28, 0.32, 0.28}, up, -17.0),
                             Shading::kFlat);
  builder.Add("tall",
              "box.obj",
              white,
              Place({-0.35, -0.38, -0.35}, {0.28, 0.62, 0.28}, up, 18.0),
              Shading::kFlat);
  builder.AddAreaLight(
      builder.Add("light", "cbox_luminaire.obj", kBlack, Place({0.0, -0.01, 0.0}), Shading::kFlat),
      {18.387, 13.9873, 6.75357});
  builder.scene.sensors = {CameraAt({0.0, 0.0, 4.0}, {0.0, 0.0, 0.0}, 39.3077)};
  result.scene = std::move(builder.scene);
  result.max_bounces = 4;
  result.direction = {1.0, 0.0, 0.0};
  return result;
}

}  // namespace

std::vector<std::string> PeerCaseNames() {
  return {"soft_shadow",
          "bunny_direct",
          "bunny_two_bounces",
          "bunny_constant_sky",
          "cornell_four_bounces"};
}

PeerCase MakePeerCase(const std::string& name, const std::filesystem::path& meshes) {
  SceneBuilder builder(meshes);
  PeerCase result;
  if (name == "soft_shadow") {
    result = SoftShadow(std::move(builder));
  } else if (name == "bunny_direct") {
    result = Bunny(std::move(builder), 1, Sky::kMap);
  } else if (name == "bunny_two_bounces") {
    result = Bunny(std::move(builder), 2, Sky::kMap);
  } else if (name == "bunny_constant_sky") {
    result = Bunny(std::move(builder), 2, Sky::kConstant);
  } else if (name == "cornell_four_bounces") {
    result = CornellFourBounces(std::move(builder));
  } else {
    throw std::invalid_argument("case '" + name +
                                "': allowed are soft_shadow, bunny_direct, bunny_two_bounces, "
                                "bunny_constant_sky, cornell_four_bounces");
  }
  result.name = name;
  renderer::ValidateScene(result.scene);
  return result;
}

}  // namespace pathfit::bench
