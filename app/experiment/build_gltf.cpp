#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "app/experiment/build_parts.h"
#include "renderer/core/error.h"
#include "renderer/io/mesh_file.h"

namespace pathfit::app {
namespace {

using renderer::Emitter;
using renderer::Material;
using renderer::Scene;
using renderer::SceneError;

/// Its own name, or behind that of the geometry if the scene has one already.
template <class List>
std::string FreeName(const std::string& name, const std::string& geometry, const List& list) {
  std::string free = name;
  for (int k = 1; HasName(list, free); ++k) {
    free =
        k == 1 ? fmt::format("{}-{}", geometry, name) : fmt::format("{}-{}-{}", geometry, name, k);
  }
  return free;
}

/// Moves what is used of a file into a scene, each once.
class Adder {
 public:
  Adder(const std::string& geometry, Scene& from, Scene& to)
      : geometry_(geometry), from_(from), to_(to) {}

  int Texture(int index) {
    if (index < 0) return index;
    const auto [entry, is_new] =
        textures_.try_emplace(index, static_cast<int>(to_.textures.size()));
    if (is_new) {
      renderer::Texture texture = from_.textures[static_cast<std::size_t>(index)];
      texture.name = FreeName(texture.name, geometry_, to_.textures);
      to_.textures.push_back(std::move(texture));
    }
    return entry->second;
  }

  int Material(int index) {
    const auto [entry, is_new] =
        materials_.try_emplace(index, static_cast<int>(to_.materials.size()));
    if (is_new) {
      renderer::Material material = from_.materials[static_cast<std::size_t>(index)];
      material.name = FreeName(material.name, geometry_, to_.materials);
      for (int* texture : {&material.base_color_texture,
                           &material.roughness_texture,
                           &material.metallic_texture,
                           &material.normal_texture}) {
        *texture = Texture(*texture);
      }
      to_.materials.push_back(std::move(material));
    }
    return entry->second;
  }

 private:
  const std::string& geometry_;
  Scene& from_;
  Scene& to_;
  std::map<int, int> textures_, materials_;
};

/// x right, y up, z backwards of a frame of the file, in the world.
renderer::Mat3 PlacedFrame(const renderer::Mat3& frame, const renderer::Transform& world) {
  const renderer::Vec3 z = renderer::Normalized(world.Direction(frame.z));
  const renderer::Vec3 x = renderer::Normalized(Cross(world.Direction(frame.y), z));
  return {x, Cross(z, x), z};
}

/// A light of the file in the world.
Emitter Placed(Emitter light, const renderer::Transform& world) {
  if (auto* point = std::get_if<renderer::PointEmitter>(&light.light)) {
    point->position = world.Point(point->position);
  } else if (auto* directional = std::get_if<renderer::DirectionalEmitter>(&light.light)) {
    directional->direction = renderer::Normalized(world.Direction(directional->direction));
  } else if (auto* spot = std::get_if<renderer::SpotEmitter>(&light.light)) {
    spot->position = world.Point(spot->position);
    spot->frame_from_light = PlacedFrame(spot->frame_from_light, world);
  }
  return light;
}

/// A camera of the file in the world, with pictures of this height.
renderer::Camera Placed(renderer::Camera camera, const renderer::Transform& world, int height_px) {
  const double ratio = static_cast<double>(height_px) / camera.height;
  camera.width = std::max(1, static_cast<int>(std::lround(ratio * camera.width)));
  camera.height = height_px;
  for (double* number : {&camera.fx, &camera.fy}) *number *= ratio;
  camera.cx = 0.5 * camera.width;
  camera.cy = 0.5 * camera.height;
  camera.world_from_camera = {PlacedFrame(camera.world_from_camera.linear, world),
                              world.Point(camera.world_from_camera.translation)};
  return camera;
}

/// Lights and cameras: taken if they are wanted, else said to be there.
void AddLightsAndCameras(const GeometryConfig& geometry,
                         const renderer::Transform& world_from_file,
                         const Scene& from,
                         const std::filesystem::path& path,
                         const BuildContext& context,
                         Scene& scene) {
  const auto check = [&](bool wanted, std::size_t count, const char* what, const char* key) {
    if (wanted && count == 0) {
      throw SceneError("geometry '" + geometry.name + "': " + path.string() + " has no " + what);
    }
    if (wanted || count == 0) return;
    context.notes.push_back(fmt::format(
        "{}: its {} are left out ({}); `{}` takes them.", path.string(), what, count, key));
  };
  std::size_t num_lights = 0;
  for (const Emitter& light : from.emitters) {
    if (std::holds_alternative<renderer::AreaEmitter>(light.light)) continue;
    ++num_lights;
    if (!geometry.lights) continue;
    Emitter placed = Placed(light, world_from_file);
    placed.name = FreeName(GroupMeshName(geometry.name, light.name), geometry.name, scene.emitters);
    scene.emitters.push_back(std::move(placed));
  }
  check(geometry.lights, num_lights, "lights", "lights: true");
  check(geometry.camera_height_px.has_value(), from.sensors.size(), "cameras", "camera_height_px");
  if (!geometry.camera_height_px) return;
  for (const renderer::Camera& camera : from.sensors) {
    renderer::Camera placed = Placed(camera, world_from_file, *geometry.camera_height_px);
    placed.name = FreeName(GroupMeshName(geometry.name, camera.name), geometry.name, scene.sensors);
    scene.sensors.push_back(std::move(placed));
  }
}

/// Index in the scene of what the configuration says instead of a material of the file; -1 for
/// nothing.
int Replacement(const std::string& name,
                const GeometryConfig& geometry,
                const ExperimentConfig& config) {
  std::string wanted = geometry.material;
  for (const auto& [from, to] : geometry.group_materials) {
    if (from == name) wanted = to;
  }
  for (std::size_t i = 0; i < config.materials.size(); ++i) {
    if (config.materials[i].name == wanted) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace

std::vector<MeshPart> ReadGltfParts(const GeometryConfig& geometry,
                                    const ExperimentConfig& config,
                                    const BuildContext& context,
                                    const renderer::Transform& world_from_file,
                                    Scene& scene) {
  const auto& path = std::get<FileGeometry>(geometry.geometry).path;
  renderer::SceneFile file = renderer::ReadSceneFile(path);
  context.files.insert(context.files.end(), file.files.begin(), file.files.end());
  for (const std::string& warning : file.warnings) context.warnings.push_back(warning);
  if (file.scene.meshes.empty()) {
    throw SceneError("geometry '" + geometry.name + "': " + path.string() + " has no triangles");
  }
  for (const auto& [name, material] : geometry.group_materials) {
    if (HasName(file.scene.materials, name)) continue;
    std::string known;
    for (const Material& m : file.scene.materials) {
      known += known.empty() ? "" : ", ";
      known += m.name;
    }
    throw SceneError(fmt::format("geometry '{}': {} has no material '{}' (known: {})",
                                 geometry.name,
                                 path.string(),
                                 name,
                                 known));
  }
  Adder adder(geometry.name, file.scene, scene);
  std::vector<MeshPart> parts;
  std::vector<bool> has_own_material(file.scene.meshes.size(), false);  // and shines by it
  std::set<std::string> names;
  for (std::size_t i = 0; i < file.scene.meshes.size(); ++i) {
    renderer::SceneMesh& mesh = file.scene.meshes[i];
    MeshPart& part = parts.emplace_back();
    // Results that are read under the same name again have it in front already.
    const std::string front = geometry.name + "-";
    if (mesh.name.starts_with(front)) mesh.name.erase(0, front.size());
    part.name =
        file.scene.meshes.size() == 1 ? geometry.name : GroupMeshName(geometry.name, mesh.name);
    const std::string name = part.name;
    for (int k = 2; !names.insert(part.name).second; ++k) part.name = fmt::format("{}-{}", name, k);
    part.mesh = std::move(mesh.mesh);
    part.material = Replacement(
        file.scene.materials[static_cast<std::size_t>(mesh.material)].name, geometry, config);
    if (part.material >= 0) continue;
    part.material = adder.Material(mesh.material);
    has_own_material[i] = true;
  }
  for (const Emitter& emitter : file.scene.emitters) {
    const auto* area = std::get_if<renderer::AreaEmitter>(&emitter.light);
    if (area == nullptr || !has_own_material[static_cast<std::size_t>(area->mesh)]) continue;
    auto& emission = parts[static_cast<std::size_t>(area->mesh)].emission;
    emission = *area;
    emission->texture = adder.Texture(area->texture);
  }
  AddLightsAndCameras(geometry, world_from_file, file.scene, path, context, scene);
  return parts;
}

}  // namespace pathfit::app
