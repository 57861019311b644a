#include <algorithm>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "app/config/map_reader.h"
#include "app/config/nearest_name.h"
#include "app/config/read_config.h"
#include "app/config/triple.h"

namespace pathfit::app {
namespace {

using Role = TextureConfig::Role;

bool Contains(const std::vector<std::string>& list, const std::string& text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

// Every material that is named exists.
void CheckMaterialNames(const YamlNode& scene, ConfigReading& reading) {
  const YamlNode* materials = scene.Find("materials");
  const YamlNode* meshes = scene.Find("geometry");
  if (materials == nullptr || meshes == nullptr) return;
  std::vector<std::string> names;
  for (const YamlEntry& entry : materials->entries) names.push_back(entry.key);
  const auto check = [&](const YamlNode& name, const std::string& path) {
    if (!name.IsScalar() || Contains(names, name.text)) return;
    reading.Report(
        name.place, path, "no material is called '" + name.text + "'" + NameHint(name.text, names));
  };
  for (const YamlEntry& entry : meshes->entries) {
    const std::string path = "scene.geometry." + entry.key;
    if (const YamlNode* name = entry.value.Find("material")) check(*name, path + ".material");
    const YamlNode* groups = entry.value.Find("materials");
    if (groups == nullptr) continue;
    for (const YamlEntry& group : groups->entries) {
      check(group.value, path + ".materials." + group.key);
    }
  }
}

void CheckMeshNames(const YamlNode& scene, ConfigReading& reading) {
  const YamlNode* meshes = scene.Find("geometry");
  if (meshes == nullptr) return;
  std::set<std::string> names;
  for (const NamedMesh& mesh : MeshesOf(reading.config)) {
    if (names.insert(mesh.name).second) continue;
    const YamlNode* node = meshes->Find(mesh.geometry->name);
    reading.Report(node->place,
                   "scene.geometry." + mesh.geometry->name,
                   "two meshes would be called '" + mesh.name + "'");
  }
}

// There is one environment at most; area lights have meshes, each its own.
void CheckLights(const YamlNode& scene, ConfigReading& reading) {
  const YamlNode* lights = scene.Find("lights");
  if (lights == nullptr) return;
  std::vector<std::string> meshes;
  for (const NamedMesh& mesh : MeshesOf(reading.config)) meshes.push_back(mesh.name);
  std::string environment;
  std::vector<std::string> shining;
  for (const YamlEntry& entry : lights->entries) {
    const YamlNode* type = entry.value.Find("type");
    if (type == nullptr) continue;
    const std::string path = "scene.lights." + entry.key;
    if (type->text == "envmap" || type->text == "constant") {
      if (environment.empty()) {
        environment = entry.key;
      } else {
        reading.Report(
            type->place,
            path,
            "only one light may be an envmap or constant; '" + environment + "' is one already");
      }
    }
    const YamlNode* mesh = entry.value.Find("mesh");
    if (mesh == nullptr) continue;
    if (!Contains(meshes, mesh->text) && !meshes.empty()) {
      reading.Report(mesh->place,
                     path + ".mesh",
                     "no mesh is called '" + mesh->text + "'" + NameHint(mesh->text, meshes));
    } else if (Contains(shining, mesh->text)) {
      reading.Report(
          mesh->place, path + ".mesh", "mesh '" + mesh->text + "' has an area light already");
    }
    shining.push_back(mesh->text);
  }
}

// Uses of textures by materials; those by lights are noted as they are read.
void UseMaterialTextures(const YamlNode& materials, ConfigReading& reading) {
  for (const YamlEntry& entry : materials.entries) {
    const auto use = [&](const char* key, Role role) {
      const YamlNode* name = MapReader(&entry.value).Map(key).Find("texture");
      if (name == nullptr) return;
      UseTexture(*name, "scene.materials." + entry.key + "." + key + ".texture", role, reading);
    };
    use("base_color", Role::kBaseColor);
    use("roughness", Role::kRoughness);
    use("metallic", Role::kMetallic);
  }
}

}  // namespace

void ReadRotation(const MapReader& map,
                  const std::string& path,
                  ConfigReading& reading,
                  Triple& axis,
                  double& angle) {
  const MapReader rotate = map.Map("rotate");
  double degrees = 0.0;
  rotate.Get("axis", axis);
  rotate.Get("angle_deg", degrees);
  angle = degrees * std::numbers::pi / 180.0;
  if (IsZero(axis)) {
    reading.Report(
        rotate.Find("axis")->place, path + ".rotate.axis", "the axis must not be [0, 0, 0]");
  }
}

std::vector<NamedMesh> MeshesOf(const ExperimentConfig& config) {
  std::vector<NamedMesh> meshes;
  for (const GeometryConfig& geometry : config.geometry) {
    meshes.push_back({geometry.name, &geometry, geometry.material});
    for (const auto& [usemtl, material] : geometry.group_materials) {
      meshes.push_back({GroupMeshName(geometry.name, usemtl), &geometry, material});
    }
  }
  return meshes;
}

void ReadScene(ConfigReading& reading) {
  YamlNode* scene = reading.root.Find("scene");
  if (scene == nullptr) return;
  ExperimentConfig& config = reading.config;
  if (const YamlNode* map = scene->Find("geometry")) {
    for (const YamlEntry& entry : map->entries) {
      config.geometry.push_back(ReadGeometry(entry, reading));
    }
  }
  ReadTextures(reading);
  if (const YamlNode* map = scene->Find("materials")) {
    for (const YamlEntry& entry : map->entries) {
      config.materials.push_back(ReadMaterial(entry, reading));
    }
    UseMaterialTextures(*map, reading);
  }
  if (YamlNode* map = scene->Find("lights")) {
    for (YamlEntry& entry : map->entries) {
      config.lights.push_back(ReadLight(entry, reading));
    }
  }
  CheckTextures(reading);
  CheckMaterialNames(*scene, reading);
  CheckMeshNames(*scene, reading);
  CheckLights(*scene, reading);
}

}  // namespace pathfit::app
