#include "app/experiment/parameter_names.h"

#include <array>
#include <utility>
#include <vector>

#include "app/config/nearest_name.h"
#include "renderer/core/error.h"

namespace pathfit::app {
namespace {

using renderer::ObjectList;
using renderer::ParameterKind;
using renderer::SceneError;

constexpr const char* kAllSensors = "camera";

std::vector<ParameterKind> AllKinds() {
  std::vector<ParameterKind> kinds;
  for (int k = 0; k <= static_cast<int>(ParameterKind::kTangentialDistortion); ++k) {
    kinds.push_back(static_cast<ParameterKind>(k));
  }
  return kinds;
}

template <class List>
std::vector<std::string> NamesOf(const List& list) {
  std::vector<std::string> names;
  for (const auto& item : list) names.push_back(item.name);
  return names;
}

std::vector<std::string> ObjectsOf(ObjectList list, const renderer::Scene& scene) {
  switch (list) {
    case ObjectList::kMeshes:
      return NamesOf(scene.meshes);
    case ObjectList::kMaterials:
      return NamesOf(scene.materials);
    case ObjectList::kTextures:
      return NamesOf(scene.textures);
    case ObjectList::kEmitters:
      return NamesOf(scene.emitters);
    case ObjectList::kSensors:
      return NamesOf(scene.sensors);
  }
  return {};
}

const char* WordOf(ObjectList list) {
  constexpr std::array<const char*, 5> kWords = {"mesh", "material", "texture", "light", "sensor"};
  return kWords.at(static_cast<std::size_t>(list));
}

bool Exists(const ParameterRef& parameter, const renderer::ParameterLayout& empty) {
  renderer::ParameterLayout layout = empty;
  try {
    layout.Add(parameter.kind, parameter.object);
  } catch (const SceneError&) {
    return false;
  }
  return true;
}

[[noreturn]] void FailNoProperty(const std::string& property) {
  std::vector<std::string> known;
  for (const ParameterKind kind : AllKinds()) {
    const std::string name = renderer::PropertyName(kind);
    if (std::find(known.begin(), known.end(), name) == known.end()) known.push_back(name);
  }
  throw SceneError("no property is called '" + property + "'" + NameHint(property, known));
}

}  // namespace

ParameterRef FindParameter(const renderer::Scene& scene,
                           const std::string& object,
                           const std::string& property) {
  const renderer::ParameterLayout empty(scene);
  const std::string name = object + "." + property;
  std::vector<ParameterRef> found;
  std::vector<std::string> known;
  bool is_property = false;
  bool is_object = false;
  bool of_sensors = false;
  for (const ParameterKind kind : AllKinds()) {
    if (property != renderer::PropertyName(kind)) continue;
    is_property = true;
    const ObjectList list = renderer::ObjectListOf(kind);
    of_sensors = of_sensors || list == ObjectList::kSensors;
    const std::vector<std::string> names = ObjectsOf(list, scene);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const ParameterRef parameter{kind, static_cast<int>(i)};
      if (names[i] == object) {
        is_object = true;
        if (Exists(parameter, empty)) found.push_back(parameter);
      }
      known.push_back(names[i]);
    }
    if (list == ObjectList::kSensors && found.empty() && object == kAllSensors && !names.empty()) {
      return {kind, -1};
    }
  }
  if (!is_property) FailNoProperty(property);
  if (found.size() > 1) {
    throw SceneError("'" + name + "' could be that of a " +
                     WordOf(renderer::ObjectListOf(found[0].kind)) + " or of a " +
                     WordOf(renderer::ObjectListOf(found[1].kind)) + "; give them different names");
  }
  if (found.size() == 1) return found.front();
  if (is_object) throw SceneError("'" + object + "' has no " + property);
  if (of_sensors) known.emplace_back(kAllSensors);
  throw SceneError("nothing that has " + property + " is called '" + object + "'" +
                   NameHint(object, known));
}

void AddParameter(const ParameterRef& parameter,
                  const renderer::Scene& scene,
                  renderer::ParameterLayout& layout) {
  if (parameter.object >= 0) {
    layout.Add(parameter.kind, parameter.object);
    return;
  }
  for (std::size_t i = 0; i < scene.sensors.size(); ++i) {
    layout.Add(parameter.kind, static_cast<int>(i));
  }
}

}  // namespace pathfit::app
