#include "app/config/unknown_names.h"

#include <algorithm>

#include "app/config/nearest_name.h"

namespace pathfit::app {
namespace {

using Owner = UnknownKind::Owner;
using Of = UnknownKind::Of;
using BaseColor = MaterialConfig::BaseColor;
using Model = MaterialConfig::Model;
using Type = LightConfig::Type;

// All sensors at once; also what a single sensor is often called.
constexpr const char* kAllSensors = "camera";

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

bool Contains(const std::vector<std::string>& list, const std::string& text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

std::string OwnerWord(Owner owner) {
  switch (owner) {
    case Owner::kMesh:
      return "mesh";
    case Owner::kMaterial:
      return "material";
    case Owner::kTexture:
      return "texture";
    case Owner::kLight:
      return "light";
    case Owner::kSensors:
      break;
  }
  return "sensor";
}

std::vector<std::string> ObjectsOf(Owner owner, const ConfigReading& reading) {
  const ExperimentConfig& config = reading.config;
  switch (owner) {
    case Owner::kMesh:
      return NamesOf(MeshesOf(config));
    case Owner::kMaterial:
      return NamesOf(config.materials);
    case Owner::kTexture:
      return NamesOf(config.textures);
    case Owner::kLight:
      return NamesOf(config.lights);
    case Owner::kSensors:
      break;
  }
  std::vector<std::string> names = NamesOf(config.sensors);
  if (!Contains(names, kAllSensors)) names.emplace_back(kAllSensors);
  return names;
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

std::string LackOfMesh(Of of, const std::string& object, const ConfigReading& reading) {
  if (of != Of::kPerVertexColor) return {};
  const std::vector<NamedMesh> meshes = MeshesOf(reading.config);
  const std::string& name = FindByName(meshes, object)->material;
  if (!IsKnown(reading, "materials", name, "base_color")) return {};
  const BaseColor source = FindByName(reading.config.materials, name)->base_color_source;
  if (source == BaseColor::kVertexConstant || source == BaseColor::kVertexOfMesh) return {};
  return " needs a material with base_color: {vertex: …}; '" + name +
         (source == BaseColor::kTexture ? "' has a texture" : "' has one colour everywhere");
}

std::string LackOfConstant(const std::string& texture) {
  return texture.empty() ? "" : " is a texture; write " + texture + ".texels";
}

std::string LackOfMaterial(Of of, const std::string& object, const ConfigReading& reading) {
  const MaterialConfig& material = *FindByName(reading.config.materials, object);
  if (of == Of::kConstantColor) {
    if (!IsKnown(reading, "materials", object, "base_color") ||
        material.base_color_source == BaseColor::kConstant) {
      return {};
    }
    if (material.base_color_source == BaseColor::kTexture) {
      return LackOfConstant(material.base_color_texture);
    }
    return " needs base_color: {constant: …}; this one is per vertex, write MESH.colors";
  }
  if (!IsKnown(reading, "materials", object, "model")) return {};
  const Model model = material.model;
  switch (of) {
    case Of::kConstantRoughness:
      if (model == Model::kMetallicRoughness || model == Model::kConductor ||
          model == Model::kDielectric) {
        return LackOfConstant(material.roughness_texture);
      }
      return " needs a material of model metallic_roughness, conductor or dielectric";
    case Of::kConstantMetallic:
      if (model == Model::kMetallicRoughness) return LackOfConstant(material.metallic_texture);
      return " needs a material of model metallic_roughness";
    case Of::kMetal:
      if (model == Model::kMirror && material.metal.empty() && material.eta == Triple{} &&
          material.k == Triple{}) {
        return " needs a mirror with metal, or eta and k";
      }
      return model == Model::kConductor || model == Model::kMirror
                 ? ""
                 : " needs a material of model conductor or mirror";
    case Of::kDielectric:
      if (model == Model::kDielectric || model == Model::kGlass) {
        return material.ior > 1.0 ? "" : " needs an ior above 1; turn the mesh inside out";
      }
      if (model == Model::kMirror || model == Model::kConductor) {
        // Has an index of the other kind, or the lack of that.
        const std::string lack = LackOfMaterial(Of::kMetal, object, reading);
        return lack.empty() ? " needs a material of model dielectric or glass" : lack;
      }
      return " needs a material of model conductor, mirror, dielectric or glass";
    default:
      return {};
  }
}

std::string LackOfTexture(Of of, const std::string& object, const ConfigReading& reading) {
  using Role = TextureConfig::Role;
  const Role role = FindByName(reading.config.textures, object)->role;
  const bool fits = of == Of::kRoughnessTexture  ? role == Role::kRoughness
                    : of == Of::kMetallicTexture ? role == Role::kMetallic
                    : of == Of::kLightTexture    ? role == Role::kLight
                                                 : role == Role::kBaseColor;
  if (fits) return {};
  return role == Role::kUnused ? " is used by no material and no light" : " has another use";
}

std::string LackOfLight(Of of, const std::string& object, const ConfigReading& reading) {
  if (!IsKnown(reading, "lights", object, "type")) return {};
  const Type type = FindByName(reading.config.lights, object)->type;
  switch (of) {
    case Of::kEnvmap:
      return type == Type::kEnvironment
                 ? ""
                 : " needs a light of type envmap; write " + object + ".intensity";
    case Of::kPlaced:
      return type == Type::kPoint || type == Type::kSpot || type == Type::kProjector
                 ? ""
                 : " needs a light of type point, spot or projector";
    case Of::kOriented:
      return type == Type::kPoint || type == Type::kArea || type == Type::kConstant
                 ? " needs a light of type envmap, directional, spot or projector"
                 : "";
    case Of::kSpot:
      return type == Type::kSpot ? "" : " needs a light of type spot";
    default:
      return {};
  }
}

std::string LackOfSensor(Of of, const std::string& object, const ConfigReading& reading) {
  const ExperimentConfig& config = reading.config;
  if (of == Of::kExposure) return " is not known here; write exposure, for all sensors";
  if (!reading.has_input && config.sensors.empty()) return {};  // reported elsewhere
  for (const SensorConfig& sensor : config.sensors) {
    const bool meant = sensor.name == object || FindByName(config.sensors, object) == nullptr;
    if (of == Of::kPerspective && meant && sensor.orthographic) {
      return " needs a perspective sensor";
    }
  }
  return {};
}

// What the object, which exists, lacks for this kind, behind its name; empty if nothing is known to
// lack.
std::string Lack(const UnknownKind& kind, const std::string& object, const ConfigReading& reading) {
  switch (kind.owner) {
    case Owner::kMesh:
      return LackOfMesh(kind.of, object, reading);
    case Owner::kMaterial:
      return LackOfMaterial(kind.of, object, reading);
    case Owner::kTexture:
      return LackOfTexture(kind.of, object, reading);
    case Owner::kLight:
      return LackOfLight(kind.of, object, reading);
    case Owner::kSensors:
      break;
  }
  return LackOfSensor(kind.of, object, reading);
}

// All names that are possible in this scene.
std::vector<std::string> PossibleNames(const ConfigReading& reading) {
  std::vector<std::string> names;
  for (const UnknownKind& kind : UnknownKinds()) {
    if (kind.of == Of::kExposure) {
      names.push_back(kind.property);
      continue;
    }
    for (const std::string& object : ObjectsOf(kind.owner, reading)) {
      if (Lack(kind, object, reading).empty()) names.push_back(object + "." + kind.property);
    }
  }
  return names;
}

UnknownName Refused(std::string text) { return {nullptr, std::move(text)}; }

UnknownName NothingCalled(const std::string& name,
                          const std::string& object,
                          const ConfigReading& reading) {
  const std::vector<std::string> possible = PossibleNames(reading);
  std::vector<std::string> own;
  for (const std::string& candidate : possible) {
    if (candidate.rfind(object + ".", 0) == 0) own.push_back(candidate);
  }
  return Refused("nothing in the scene is called '" + name + "'" +
                 NameHint(name, own.empty() ? possible : own));
}

// A property of the camera of one photo, whose name (with a dot) is known when the photos are read.
const UnknownKind* KindOfPhoto(const std::string& object,
                               const std::string& property,
                               const ConfigReading& reading) {
  if (!reading.has_input || object.find('.') == std::string::npos) return nullptr;
  const auto& kinds = UnknownKinds();
  const auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const UnknownKind& k) {
    return k.owner == Owner::kSensors && k.of != Of::kExposure && k.property == property;
  });
  return kind == kinds.end() ? nullptr : &*kind;
}

UnknownName FindExposure(const ConfigReading& reading) {
  const auto& kinds = UnknownKinds();
  const auto kind = std::find_if(
      kinds.begin(), kinds.end(), [](const UnknownKind& k) { return k.of == Of::kExposure; });
  const auto& input = reading.config.input;
  if (reading.has_input && input && !input->exposure_gain) {
    return {&*kind, "'exposure' needs input.exposure.model: gain"};
  }
  return {&*kind, ""};
}

}  // namespace

UnknownName FindUnknown(const std::string& name, const ConfigReading& reading) {
  if (name == "exposure") return FindExposure(reading);
  const std::size_t dot = name.rfind('.');
  const std::string object = name.substr(0, dot);
  const std::string property = dot == std::string::npos ? "" : name.substr(dot + 1);
  if (const UnknownKind* kind = KindOfPhoto(object, property, reading)) return {kind, ""};
  std::vector<const UnknownKind*> fitting;
  std::vector<std::string> objects;  // of those that could have the property
  const UnknownKind* lacking = nullptr;
  const UnknownKind* first = nullptr;
  std::string lack, owners;
  for (const UnknownKind& kind : UnknownKinds()) {
    if (kind.property != property) continue;
    if (first == nullptr) first = &kind;
    const std::vector<std::string> own = ObjectsOf(kind.owner, reading);
    const std::string word = OwnerWord(kind.owner);
    if (!own.empty() && owners.find(word) == std::string::npos) {
      owners += (owners.empty() ? "" : " or ") + word;
    }
    for (const std::string& o : own) {
      if (!Contains(objects, o)) objects.push_back(o);
    }
    if (!Contains(own, object)) continue;
    lacking = &kind;
    lack = Lack(kind, object, reading);
    if (lack.empty()) fitting.push_back(&kind);
  }
  if (first == nullptr) return NothingCalled(name, object, reading);
  if (fitting.size() == 1) return {fitting.front(), ""};
  if (fitting.size() > 1) {
    return Refused("'" + name + "' could be that of a " + OwnerWord(fitting[0]->owner) +
                   " or of a " + OwnerWord(fitting[1]->owner) + "; give them different names");
  }
  if (lacking != nullptr) return {lacking, "'" + name + "'" + lack};
  if (objects.empty() && first->owner != Owner::kLight) return {first, ""};
  if (owners.empty()) owners = OwnerWord(first->owner);
  return {first, "no " + owners + " is called '" + object + "'" + NameHint(object, objects)};
}

}  // namespace pathfit::app
