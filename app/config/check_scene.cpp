// What several values of a scene must be together: names exist, textures have one use.
#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "app/config/nearest_name.h"
#include "app/config/read_config.h"
#include "renderer/bsdf/bsdf.h"

namespace pathfit::app {
namespace {

using Role = TextureConfig::Role;

const std::vector<YamlEntry>& EntriesOf(const YamlNode& scene, const char* list) {
  static const YamlNode none;
  const YamlNode* node = scene.Find(list);
  return (node == nullptr ? none : *node).entries;
}

void ReportNothingCalled(const YamlNode& name,
                         const std::string& path,
                         const char* noun,
                         const std::vector<std::string>& names,
                         ConfigReading& reading) {
  reading.Report(name.place,
                 path,
                 fmt::format("no {} is called '{}'", noun, name.text) + NameHint(name.text, names));
}

bool IsData(Role role) { return role == Role::kRoughness || role == Role::kMetallic; }

const char* Describe(Role role) {
  return role == Role::kNormal ? "normals" : IsData(role) ? "roughness or metallic" : "a colour";
}

bool CanBeBoth(Role a, Role b) {
  return IsData(a) == IsData(b) && (a == Role::kNormal) == (b == Role::kNormal);
}

// Notes what the texture is used for: of two uses the one with narrower values (roughness, base
// colour).
void UseTexture(const YamlNode& name, const std::string& path, Role role, ConfigReading& reading) {
  std::vector<std::string> names;
  for (TextureConfig& texture : reading.config.textures) {
    names.push_back(texture.name);
    if (texture.name != name.text) continue;
    if (texture.role != Role::kUnused && !CanBeBoth(texture.role, role)) {
      reading.Report(name.place,
                     path,
                     fmt::format("texture '{}' is used as {} already, so it cannot be {}; name its "
                                 "file twice",
                                 name.text,
                                 Describe(texture.role),
                                 Describe(role)));
      return;
    }
    if (texture.role == Role::kUnused || texture.role == Role::kLight || role == Role::kRoughness) {
      texture.role = role;
    }
    return;
  }
  ReportNothingCalled(name, path, "texture", names, reading);
}

// What the start value of a texture without file must lie in.
std::pair<double, double> StartRange(Role role) {
  if (role == Role::kRoughness) return {renderer::kMinRoughness, 1.0};
  return {0.0, role == Role::kLight || role == Role::kUnused ? 1e20 : 1.0};
}

void CheckStartValue(const TextureConfig& texture, ConfigReading& reading) {
  const YamlNode* start = reading.root.Find("scene")->Find("textures")->Find(texture.name);
  for (const char* key : {"init", "constant"}) start = start == nullptr ? start : start->Find(key);
  if (start == nullptr) return;
  const std::string path = "scene.textures." + texture.name + ".init.constant";
  const auto [low, high] = StartRange(texture.role);
  for (const double value : texture.init) {
    if (value >= low && value <= high) continue;
    reading.Report(start->place,
                   path,
                   fmt::format("{} is out of range (allowed for {}: from {} to {})",
                               value,
                               texture.role == Role::kRoughness   ? "roughness"
                               : texture.role == Role::kMetallic  ? "metallic"
                               : texture.role == Role::kBaseColor ? "a base colour"
                               : texture.role == Role::kNormal    ? "normals"
                                                                  : "a light",
                               low,
                               high));
    return;
  }
  if (IsData(texture.role) &&
      (texture.init[0] != texture.init[1] || texture.init[0] != texture.init[2])) {
    reading.Report(start->place, path, "roughness and metallic are one number, not a colour");
  }
}

// Every use of a texture, in materials and lights.
void CheckTextures(const YamlNode& scene, ConfigReading& reading) {
  for (const YamlEntry& entry : EntriesOf(scene, "materials")) {
    const auto use = [&](const char* key, Role role) {
      const YamlNode* source = entry.value.Find(key);
      const YamlNode* name = source == nullptr ? nullptr : source->Find("texture");
      if (name == nullptr) return;
      UseTexture(*name, "scene.materials." + entry.key + "." + key + ".texture", role, reading);
    };
    use("base_color", Role::kBaseColor);
    use("roughness", Role::kRoughness);
    use("metallic", Role::kMetallic);
    use("normal", Role::kNormal);
  }
  for (const YamlEntry& entry : EntriesOf(scene, "lights")) {
    const YamlNode* name = entry.value.Find("texture");
    if (name == nullptr) continue;
    UseTexture(*name, "scene.lights." + entry.key + ".texture", Role::kLight, reading);
  }
  for (const TextureConfig& texture : reading.config.textures) CheckStartValue(texture, reading);
}

// Every material that is named exists.
void CheckMaterialNames(const YamlNode& scene, ConfigReading& reading) {
  std::vector<std::string> names;
  for (const YamlEntry& entry : EntriesOf(scene, "materials")) names.push_back(entry.key);
  const auto check = [&](const YamlNode& name, const std::string& path) {
    if (!name.IsScalar() || Contains(names, name.text)) return;
    ReportNothingCalled(name, path, "material", names, reading);
  };
  for (const YamlEntry& entry : EntriesOf(scene, "geometry")) {
    const std::string path = "scene.geometry." + entry.key;
    if (const YamlNode* name = entry.value.Find("material")) check(*name, path + ".material");
    for (const YamlEntry& group : EntriesOf(entry.value, "materials")) {
      check(group.value, path + ".materials." + group.key);
    }
  }
}

void CheckMeshes(const YamlNode& scene, ConfigReading& reading) {
  std::set<std::string> names;
  for (const NamedMesh& mesh : MeshesOf(reading.config)) {
    if (names.insert(mesh.name).second) continue;
    const std::string& name = mesh.geometry->name;
    reading.Report(scene.Find("geometry")->Find(name)->place,
                   "scene.geometry." + name,
                   "two meshes would be called '" + mesh.name + "'");
  }
  const auto& input = reading.config.input;
  if (input && input->photos.masks.meaning == optim::MaskMeaning::kSilhouette) return;
  for (const YamlEntry& entry : EntriesOf(scene, "geometry")) {
    const YamlNode* hull = entry.value.Find("visual_hull");
    if (hull == nullptr) continue;
    reading.Report(hull->place,
                   "scene.geometry." + entry.key + ".visual_hull",
                   "a visual hull is carved from masks; input.masks with meaning: silhouette is "
                   "needed");
  }
}

// There is one environment at most; area lights have meshes, each its own.
void CheckLights(const YamlNode& scene, ConfigReading& reading) {
  std::vector<std::string> meshes;
  for (const NamedMesh& mesh : MeshesOf(reading.config)) meshes.push_back(mesh.name);
  std::string environment;
  std::vector<std::string> shining;
  for (const YamlEntry& entry : EntriesOf(scene, "lights")) {
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
    // Of a glTF file only building tells.
    const bool is_part = std::ranges::any_of(reading.config.geometry, [&](const auto& geometry) {
      return IsGltf(geometry) && mesh->text.starts_with(geometry.name + "-");
    });
    if (!Contains(meshes, mesh->text) && !is_part && !meshes.empty()) {
      ReportNothingCalled(*mesh, path + ".mesh", "mesh", meshes, reading);
    } else if (Contains(shining, mesh->text)) {
      reading.Report(
          mesh->place, path + ".mesh", "mesh '" + mesh->text + "' has an area light already");
    }
    shining.push_back(mesh->text);
  }
}

// A rectangle is a black mesh that shines: derivatives, shadows and exports need to know no more.
void AddRectangles(const YamlNode& scene, ConfigReading& reading) {
  ExperimentConfig& config = reading.config;
  const std::vector<YamlEntry>& lights = EntriesOf(scene, "lights");
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const YamlNode* type = lights[i].value.Find("type");
    if (type == nullptr || type->text != "rectangle") continue;
    LightConfig& light = config.lights[i];
    const auto is_taken = [&](const auto& list) {
      return std::ranges::any_of(list, [&](const auto& item) { return item.name == light.name; });
    };
    if (is_taken(config.materials) || is_taken(MeshesOf(config))) {
      reading.Report(type->place,
                     "scene.lights." + light.name,
                     "a rectangle needs a name that no mesh and no material has");
      continue;
    }
    light.mesh = light.name;
    GeometryConfig& geometry = config.geometry.emplace_back();
    geometry.name = geometry.material = light.name;
    geometry.geometry = RectangleGeometry{};
    geometry.transform = {
        {0.5 * light.width_m, 0.5 * light.height_m, 1.0}, light.axis, light.angle, light.position};
    MaterialConfig& material = config.materials.emplace_back();
    material.name = light.name;
    material.base_color = {0.0, 0.0, 0.0};
  }
}

// The one sensor that took all photos.
void CheckFixedSensor(const std::string& name, const YamlNode& scene, ConfigReading& reading) {
  std::vector<std::string> names;
  for (const YamlEntry& entry : EntriesOf(scene, "sensors")) {
    names.push_back(entry.key);
    if (entry.key == name) continue;
    reading.Report(entry.key_place,
                   "scene.sensors",
                   "it is not used: the photos are those of '" + name + "' (input.cameras.sensor)");
  }
  if (Contains(names, name)) return;
  const YamlNode* sensor = reading.root.Find("input")->Find("cameras")->Find("sensor");
  ReportNothingCalled(*sensor, "input.cameras.sensor", "sensor", names, reading);
}

void CheckSensors(const YamlNode& scene, ConfigReading& reading) {
  const YamlNode* sensors = scene.Find("sensors");
  const std::string fixed = reading.config.input ? reading.config.input->sensor : "";
  if (!fixed.empty()) {
    CheckFixedSensor(fixed, scene, reading);
  } else if (sensors != nullptr && reading.has_input) {
    reading.Report(sensors->place,
                   "scene.sensors",
                   "sensors are not supported together with input; the photos are the cameras, "
                   "unless input.cameras.sensor names one that took them all");
  }
  bool has_sensors = sensors != nullptr && !sensors->entries.empty();
  for (const GeometryConfig& geometry : reading.config.geometry) {
    if (!geometry.camera_height_px) continue;
    has_sensors = true;
    if (!reading.has_input || !IsGltf(geometry)) continue;
    const YamlNode* entry = scene.Find("geometry")->Find(geometry.name);
    reading.Report(entry->Find("camera_height_px")->place,
                   "scene.geometry." + geometry.name + ".camera_height_px",
                   "cameras of a file are not supported together with input; the photos are the "
                   "cameras");
  }
  if (!reading.has_input && !has_sensors) {
    reading.Report(scene.place, "scene", "there is no camera; give input or scene.sensors");
  }
}

// Indices of the unknowns that a stage frees.
std::vector<int> FreeOf(const YamlNode& node, const std::string& path, ConfigReading& reading) {
  const std::vector<optim::UnknownSpec>& unknowns = reading.config.fit.unknowns;
  std::vector<std::string> known;
  std::vector<int> free;
  for (const optim::UnknownSpec& unknown : unknowns) {
    if (!node.IsList() && !unknown.hold) free.push_back(static_cast<int>(known.size()));
    known.push_back(unknown.name);
  }
  if (!node.IsList() && free.empty()) {
    reading.Report(node.place,
                   path,
                   known.empty() ? "there are no unknowns to free" : "every unknown is held");
  }
  for (const YamlNode& item : node.items) {
    const auto index = static_cast<int>(std::ranges::find(known, item.text) - known.begin());
    if (index == static_cast<int>(known.size())) {
      ReportNothingCalled(item, path, "unknown", known, reading);
    } else if (unknowns[static_cast<std::size_t>(index)].hold) {
      reading.Report(item.place, path, "'" + item.text + "' is held (hold: true)");
    } else if (std::ranges::find(free, index) != free.end()) {
      reading.Report(item.place, path, "'" + item.text + "' is given twice");
    } else {
      free.push_back(index);
    }
  }
  return free;
}

}  // namespace

std::vector<NamedMesh> MeshesOf(const ExperimentConfig& config) {
  std::vector<NamedMesh> meshes;
  for (const GeometryConfig& geometry : config.geometry) {
    meshes.push_back({geometry.name, &geometry, geometry.material});
    if (IsGltf(geometry)) continue;
    for (const auto& [usemtl, material] : geometry.group_materials) {
      meshes.push_back({GroupMeshName(geometry.name, usemtl), &geometry, material});
    }
  }
  return meshes;
}

void CheckScene(ConfigReading& reading) {
  const YamlNode* scene = reading.root.Find("scene");
  if (scene == nullptr) return;
  AddRectangles(*scene, reading);
  CheckTextures(*scene, reading);
  CheckMaterialNames(*scene, reading);
  CheckMeshes(*scene, reading);
  CheckLights(*scene, reading);
  CheckSensors(*scene, reading);
}

void CheckStages(ConfigReading& reading) {
  const YamlNode* stages = reading.root.Find("stages");
  if (stages == nullptr) return;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < stages->items.size(); ++i) {
    const YamlNode& node = stages->items[i];
    const std::string path = fmt::format("stages[{}]", i);
    if (const YamlNode* free = node.Find("free")) {
      reading.config.fit.stages[i].free = FreeOf(*free, path + ".free", reading);
    }
    const YamlNode* name = node.Find("name");
    if (name == nullptr) continue;
    if (name->text == "start") {
      reading.Report(name->place,
                     path + ".name",
                     "'start' is what the scene before the first stage is called; choose another");
    }
    if (std::ranges::find(names, name->text) != names.end()) {
      reading.Report(
          name->place, path + ".name", "another stage is called '" + name->text + "' already");
    }
    names.push_back(name->text);
  }
  if (!stages->items.empty() && !reading.has_input) {
    reading.Report(stages->place, "stages", "a fit needs photos; give input");
  }
}

}  // namespace pathfit::app
