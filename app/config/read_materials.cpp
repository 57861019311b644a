#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "app/config/map_reader.h"
#include "app/config/nearest_name.h"
#include "app/config/read_config.h"

namespace pathfit::app {
namespace {

using Role = TextureConfig::Role;

MaterialConfig::Model ModelOf(const std::string& word) {
  using Model = MaterialConfig::Model;
  if (word == "metallic_roughness") return Model::kMetallicRoughness;
  if (word == "conductor") return Model::kConductor;
  if (word == "dielectric") return Model::kDielectric;
  if (word == "mirror") return Model::kMirror;
  if (word == "glass") return Model::kGlass;
  return Model::kDiffuse;
}

bool IsData(Role role) { return role == Role::kRoughness || role == Role::kMetallic; }

const char* Describe(Role role) { return IsData(role) ? "roughness or metallic" : "a colour"; }

TextureConfig ReadTexture(const YamlEntry& entry) {
  const MapReader map(&entry.value);
  TextureConfig texture;
  texture.name = entry.key;
  map.Get("file", texture.file);
  map.Get("size_px", texture.size_px);
  if (const YamlNode* init = map.Map("init").Find("constant")) {
    const std::vector<double> v = NumbersOf(*init);
    texture.init = v.size() == 3 ? Triple{v[0], v[1], v[2]} : Triple{v[0], v[0], v[0]};
  }
  texture.repeat = map.TextOf("wrap") != "clamp";
  return texture;
}

// What the start value of a texture without file must lie in.
std::pair<double, double> StartRange(Role role) {
  constexpr double kMinRoughness = 0.1;
  if (role == Role::kRoughness) return {kMinRoughness, 1.0};
  return {0.0, role == Role::kLight || role == Role::kUnused ? 1e30 : 1.0};
}

void CheckStartValue(const TextureConfig& texture, ConfigReading& reading) {
  const YamlNode* scene = reading.root.Find("scene");
  const MapReader map(scene->Find("textures")->Find(texture.name));
  const YamlNode* init = map.Map("init").Find("constant");
  if (init == nullptr) return;
  const std::string path = "scene.textures." + texture.name + ".init.constant";
  const auto [low, high] = StartRange(texture.role);
  for (const double value : texture.init) {
    if (value >= low && value <= high) continue;
    reading.Report(init->place,
                   path,
                   fmt::format("{} is out of range (allowed for {}: from {} to {})",
                               value,
                               texture.role == Role::kRoughness  ? "roughness"
                               : texture.role == Role::kMetallic ? "metallic"
                                                                 : "a base colour",
                               low,
                               high));
    return;
  }
  if (IsData(texture.role) &&
      (texture.init[0] != texture.init[1] || texture.init[0] != texture.init[2])) {
    reading.Report(init->place, path, "roughness and metallic are one number, not a colour");
  }
}

}  // namespace

MaterialConfig ReadMaterial(const YamlEntry& entry, ConfigReading& reading) {
  const std::string path = "scene.materials." + entry.key;
  const MapReader map(&entry.value);
  MaterialConfig material;
  material.name = entry.key;
  material.model = ModelOf(map.TextOf("model"));
  const MapReader base_color = map.Map("base_color");
  base_color.Get("constant", material.base_color);
  if (const YamlNode* vertex = base_color.Find("vertex")) {
    material.base_color_source = vertex->IsList() ? MaterialConfig::BaseColor::kVertexConstant
                                                  : MaterialConfig::BaseColor::kVertexOfMesh;
    base_color.Get("vertex", material.base_color);
  }
  if (base_color.Has("texture")) {
    material.base_color_source = MaterialConfig::BaseColor::kTexture;
    base_color.Get("texture", material.base_color_texture);
  }
  map.Map("roughness").Get("constant", material.roughness);
  map.Map("roughness").Get("texture", material.roughness_texture);
  map.Map("metallic").Get("constant", material.metallic);
  map.Map("metallic").Get("texture", material.metallic_texture);
  map.Get("metal", material.metal);
  map.Get("eta", material.eta);
  map.Get("k", material.k);
  map.Get("ior", material.ior);
  if (material.ior == 1.0) {
    reading.Report(map.Find("ior")->place,
                   path + ".ior",
                   "an ior of 1 is no surface; take the mesh out of the scene instead");
  }
  map.Get("two_sided", material.two_sided);
  return material;
}

void ReadTextures(ConfigReading& reading) {
  const YamlNode* scene = reading.root.Find("scene");
  const YamlNode* textures = scene == nullptr ? nullptr : scene->Find("textures");
  if (textures == nullptr) return;
  for (const YamlEntry& entry : textures->entries) {
    reading.config.textures.push_back(ReadTexture(entry));
  }
}

void UseTexture(const YamlNode& name, const std::string& path, Role role, ConfigReading& reading) {
  std::vector<std::string> names;
  for (TextureConfig& texture : reading.config.textures) {
    names.push_back(texture.name);
    if (texture.name != name.text) continue;
    if (texture.role != Role::kUnused && IsData(texture.role) != IsData(role)) {
      reading.Report(name.place,
                     path,
                     fmt::format("texture '{}' is used as {} already, so it cannot be {}; name its "
                                 "file twice",
                                 name.text,
                                 Describe(texture.role),
                                 Describe(role)));
      return;
    }
    // Of two uses the one with narrower values: roughness, base colour.
    if (texture.role == Role::kUnused || texture.role == Role::kLight || role == Role::kRoughness) {
      texture.role = role;
    }
    return;
  }
  reading.Report(
      name.place, path, "no texture is called '" + name.text + "'" + NameHint(name.text, names));
}

void CheckTextures(ConfigReading& reading) {
  for (const TextureConfig& texture : reading.config.textures) CheckStartValue(texture, reading);
}

}  // namespace pathfit::app
