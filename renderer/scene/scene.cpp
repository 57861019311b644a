#include "renderer/scene/scene.h"

#include <algorithm>
#include <variant>

namespace pathfit::renderer {

bool ShowsEnvironment(const Scene& scene) {
  return scene.environment_visible &&
         std::ranges::any_of(scene.emitters, [](const Emitter& emitter) {
           return std::holds_alternative<EnvironmentEmitter>(emitter.light);
         });
}

const AreaEmitter* AreaLightOf(const Scene& scene, std::size_t mesh) {
  for (const Emitter& emitter : scene.emitters) {
    const auto* area = std::get_if<AreaEmitter>(&emitter.light);
    if (area != nullptr && area->mesh == static_cast<int>(mesh)) return area;
  }
  return nullptr;
}

Mesh WorldMesh(const SceneMesh& mesh) {
  const ObjectPose& pose = mesh.pose;
  Mesh world = mesh.mesh;
  const bool is_turned = !(pose.rotation == Vec3{});
  if (!is_turned && pose.translation == Vec3{} && pose.scale == 1.0) {
    return world;  // to the last bit
  }
  const Mat3 rotation = is_turned ? RotationFromVector(pose.rotation) : Mat3{};
  const Vec3 moved_pivot = pose.pivot + pose.translation;
  for (Vec3& x : world.positions) {
    x = moved_pivot + rotation * (x - pose.pivot) * pose.scale;
  }
  for (Vec3& normal : world.normals) {
    normal = rotation * normal;
  }
  return world;
}

std::vector<Mesh> WorldMeshes(const Scene& scene) {
  std::vector<Mesh> meshes;
  meshes.reserve(scene.meshes.size());
  for (const SceneMesh& mesh : scene.meshes) {
    meshes.push_back(WorldMesh(mesh));
  }
  return meshes;
}

}  // namespace pathfit::renderer
