#include "app/config/unknown_names.h"

#include <algorithm>
#include <limits>

#include "app/config/nearest_name.h"

namespace pathfit::app {
namespace {

using Owner = UnknownKind::Owner;
using BaseColor = MaterialConfig::BaseColor;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class List>
std::vector<std::string> NamesOf(const List& list) {
  std::vector<std::string> names;
  names.reserve(list.size());
  for (const auto& item : list) names.push_back(item.name);
  return names;
}

template <class List>
auto FindByName(const List& list, const std::string& name) -> decltype(list.data()) {
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const auto& item) { return item.name == name; });
  return found == list.end() ? nullptr : &*found;
}

std::string OwnerWord(Owner owner) {
  return owner == Owner::kMesh ? "mesh" : owner == Owner::kMaterial ? "material" : "light";
}

std::vector<std::string> ObjectsOf(Owner owner, const ExperimentConfig& config) {
  if (owner == Owner::kMesh) return NamesOf(config.geometry);
  if (owner == Owner::kMaterial) return NamesOf(config.materials);
  return NamesOf(config.lights);
}

// scene.<list>.<object> has this key, so it was given and right.
bool IsKnown(const ConfigReading& reading,
             const std::string& list,
             const std::string& object,
             const std::string& key) {
  const YamlNode* node = &reading.root;
  for (const std::string& step : {std::string("scene"), list, object, key}) {
    node = node->Find(step);
    if (node == nullptr) return false;
  }
  return true;
}

std::string LackOfMaterial(const std::string& object,
                           const std::string& property,
                           const ConfigReading& reading) {
  const MaterialConfig* material = FindByName(reading.config.materials, object);
  if (property == "base_color") {
    if (!IsKnown(reading, "materials", object, "base_color") ||
        material->base_color_source == BaseColor::kConstant) {
      return {};
    }
    return " needs base_color: {constant: …}; this one is per vertex, write MESH.colors";
  }
  if (!IsKnown(reading, "materials", object, "model") || material->metallic_roughness) return {};
  return " needs a material of model metallic_roughness";
}

// What the object lacks for this property, behind its name; empty if nothing is known to lack.
std::string Lack(const std::string& object,
                 const std::string& property,
                 const ConfigReading& reading) {
  const ExperimentConfig& config = reading.config;
  if (property == "colors") {
    const std::string& name = FindByName(config.geometry, object)->material;
    const MaterialConfig* material = FindByName(config.materials, name);
    if (!IsKnown(reading, "materials", name, "base_color") ||
        material->base_color_source != BaseColor::kConstant) {
      return {};
    }
    return " needs a material with base_color: {vertex: …}; '" + name +
           "' has one colour everywhere";
  }
  if (property == "texels") {
    if (!IsKnown(reading, "lights", object, "type") ||
        FindByName(config.lights, object)->type == LightConfig::Type::kEnvironment) {
      return {};
    }
    return " needs a light of type envmap; write " + object + ".intensity";
  }
  const bool of_material =
      property == "base_color" || property == "roughness" || property == "metallic";
  return of_material ? LackOfMaterial(object, property, reading) : std::string();
}

// All names that are possible in this scene.
std::vector<std::string> PossibleNames(const ConfigReading& reading) {
  std::vector<std::string> names;
  for (const UnknownKind& kind : UnknownKinds()) {
    if (kind.owner == Owner::kPhotos) {
      names.push_back(kind.property);
      continue;
    }
    for (const std::string& object : ObjectsOf(kind.owner, reading.config)) {
      if (Lack(object, kind.property, reading).empty()) {
        names.push_back(object + "." + kind.property);
      }
    }
  }
  return names;
}

}  // namespace

const std::vector<UnknownKind>& UnknownKinds() {
  static const std::vector<UnknownKind> all_kinds = {
      {"vertices", Owner::kMesh, "", "", 0.0, 0.0, false, false, {"laplacian"}},
      {"colors", Owner::kMesh, "[0.01, 0.99]", "", 0.0, 1.0, false, true, {"smooth"}},
      {"base_color", Owner::kMaterial, "[0.01, 0.99]", "", 0.0, 1.0, false, true, {"gaussian"}},
      {"roughness", Owner::kMaterial, "[0.1, 1]", "", 0.1, 1.0, false, false, {"gaussian"}},
      {"metallic", Owner::kMaterial, "[0, 1]", "", 0.0, 1.0, false, false, {"gaussian"}},
      {"intensity", Owner::kLight, "[1e-4, .inf]", "", 0.0, kInfinity, true, true, {"gaussian"}},
      {"texels",
       Owner::kLight,
       "[1e-4, .inf]",
       "",
       0.0,
       kInfinity,
       true,
       true,
       {"smooth", "neutral"}},
      {"exposure", Owner::kPhotos, "", "; write input.exposure.max_ev", 0.0, 0.0, false, false, {}},
  };
  return all_kinds;
}

const UnknownKind* FindUnknownKind(const std::string& property) {
  const auto& kinds = UnknownKinds();
  const auto found = std::find_if(
      kinds.begin(), kinds.end(), [&](const UnknownKind& k) { return k.property == property; });
  return found == kinds.end() ? nullptr : &*found;
}

std::string UnknownNameProblem(const std::string& name, const ConfigReading& reading) {
  const ExperimentConfig& config = reading.config;
  if (name == "exposure") {
    if (!reading.has_input || !config.input || config.input->exposure_gain) return {};
    return "'exposure' needs input.exposure.model: gain";
  }
  const std::size_t dot = name.find('.');
  const std::string object = name.substr(0, dot);
  const std::string property = dot == std::string::npos ? "" : name.substr(dot + 1);
  const UnknownKind* kind = FindUnknownKind(property);
  if (kind == nullptr || kind->owner == Owner::kPhotos) {
    const std::vector<std::string> possible = PossibleNames(reading);
    std::vector<std::string> own;
    for (const std::string& candidate : possible) {
      if (candidate.rfind(object + ".", 0) == 0) own.push_back(candidate);
    }
    return "nothing in the scene is called '" + name + "'" +
           NameHint(name, own.empty() ? possible : own);
  }
  const std::vector<std::string> objects = ObjectsOf(kind->owner, config);
  if (std::find(objects.begin(), objects.end(), object) != objects.end()) {
    const std::string lack = Lack(object, property, reading);
    return lack.empty() ? lack : "'" + name + "'" + lack;
  }
  if (objects.empty() && kind->owner != Owner::kLight) return {};
  return "no " + OwnerWord(kind->owner) + " is called '" + object + "'" + NameHint(object, objects);
}

}  // namespace pathfit::app
