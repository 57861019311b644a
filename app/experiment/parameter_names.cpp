#include "app/experiment/parameter_names.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "app/config/nearest_name.h"

namespace pathfit::app {
namespace {

using renderer::kAllSensors;
using renderer::ObjectList;
using renderer::ParameterKind;
using renderer::ParameterTraits;
using renderer::Scene;

// The rows of which each is the first of its kind.
std::vector<const ParameterTraits*> Kinds() {
  std::vector<const ParameterTraits*> kinds;
  for (const ParameterTraits& row : renderer::AllParameterTraits()) {
    if (kinds.empty() || kinds.back()->kind != row.kind) kinds.push_back(&row);
  }
  return kinds;
}

// "a material of model conductor, mirror, dielectric or glass": of all rows of the kind.
std::string NeededObject(const ParameterTraits& kind) {
  std::string objects;
  for (const ParameterTraits& row : renderer::AllParameterTraits()) {
    if (row.kind == kind.kind) objects += (objects.empty() ? "" : ", ") + std::string(row.objects);
  }
  const std::size_t last = objects.rfind(", ");
  if (last != std::string::npos) objects.replace(last, 2, " or ");
  switch (kind.list) {
    case ObjectList::kMaterials:
      return "a material of model " + objects;
    case ObjectList::kEmitters:
      return "a light of type " + objects;
    case ObjectList::kSensors:
      return "a " + objects + " sensor";
    default:
      return objects.rfind("a ", 0) == 0 ? objects : "a mesh with " + objects;
  }
}

// Behind the object's name; empty if it lacks nothing.
std::string Lack(const ParameterTraits& kind, const Scene& scene, int object) {
  const ParameterTraits& row = renderer::TraitsOf(kind.kind, scene, object);
  const bool has_numbers = row.read(scene, object).num_blocks > 0;
  if (has_numbers || kind.list == ObjectList::kMeshes || kind.list == ObjectList::kEmitters) {
    if (std::string lack = row.lack(scene, object); !lack.empty()) return lack;
  }
  return has_numbers ? "" : " needs " + NeededObject(kind);
}

// Of all sensors: what the first one lacks that lacks something.
std::string LackOfSensors(const ParameterTraits& kind, const Scene& scene) {
  for (std::size_t i = 0; i < scene.sensors.size(); ++i) {
    if (std::string lack = Lack(kind, scene, static_cast<int>(i)); !lack.empty()) return lack;
  }
  return {};
}

// What may be written before the property, with its index.
std::vector<std::pair<std::string, int>> ObjectsOf(const ParameterTraits& kind,
                                                   const Scene& scene) {
  std::vector<std::pair<std::string, int>> objects;
  const std::vector<std::string> names = renderer::ObjectNames(scene, kind.list);
  for (std::size_t i = 0; i < names.size(); ++i) {
    objects.emplace_back(names[i], static_cast<int>(i));
  }
  // A single sensor is often called so, too.
  if (kind.list == ObjectList::kSensors && !names.empty() && !Contains(names, kAllSensors)) {
    objects.emplace_back(kAllSensors, -1);
  }
  return objects;
}

std::string LackOf(const ParameterTraits& kind, const Scene& scene, int object) {
  return object < 0 ? LackOfSensors(kind, scene) : Lack(kind, scene, object);
}

std::string NothingCalled(const std::string& name, const std::string& object, const Scene& scene) {
  std::vector<std::string> possible;
  std::vector<std::string> own;
  for (const ParameterTraits* kind : Kinds()) {
    for (const auto& [candidate, index] : ObjectsOf(*kind, scene)) {
      if (!LackOf(*kind, scene, index).empty()) continue;
      possible.push_back(candidate + "." + kind->property);
      if (candidate == object) own.push_back(possible.back());
    }
  }
  return "nothing in the scene is called '" + name + "'" +
         NameHint(name, own.empty() ? possible : own);
}

}  // namespace

std::vector<std::string> NamesLike(const Scene& scene, const std::string& name) {
  const std::size_t dot = name.rfind('.');
  if (dot == std::string::npos || name.find_first_of("*?[") >= dot) return {name};
  if (FindParameter(scene, name).problem.empty()) return {name};  // is called so
  const std::string pattern = name.substr(0, dot);
  const std::string property = name.substr(dot + 1);
  std::vector<std::string> names;
  for (const ParameterTraits* kind : Kinds()) {
    if (kind->property != property) continue;
    for (const auto& [object, index] : ObjectsOf(*kind, scene)) {
      const bool fits = index >= 0 && MatchesGlob(pattern, object);
      if (!fits || !LackOf(*kind, scene, index).empty()) continue;
      const std::string found = object + "." + property;
      if (!Contains(names, found)) names.push_back(found);
    }
  }
  return names.empty() ? std::vector<std::string>{name} : names;
}

ParameterName FindParameter(const Scene& scene, const std::string& name) {
  for (const ParameterKind kind : {ParameterKind::kExposure, ParameterKind::kWhiteBalance}) {
    if (name == renderer::TraitsOf(kind).property) return {{kind, -1}, ""};
  }
  const std::size_t dot = name.rfind('.');  // names of photos have dots
  const std::string object = name.substr(0, dot);
  const std::string property = dot == std::string::npos ? "" : name.substr(dot + 1);
  std::vector<ParameterName> fitting;
  std::string lack;
  std::vector<std::string> objects;  // of those that could have the property
  std::string owners;
  const ParameterTraits* first = nullptr;
  for (const ParameterTraits* kind : Kinds()) {
    if (kind->property != property) continue;
    if (first == nullptr) first = kind;
    const auto own = ObjectsOf(*kind, scene);
    if (!own.empty()) {
      owners += (owners.empty() ? "" : " or ") + std::string(renderer::ObjectWord(kind->list));
    }
    for (const auto& [candidate, index] : own) {
      if (!Contains(objects, candidate)) objects.push_back(candidate);
      if (candidate != object) continue;
      ParameterName found{{kind->kind, index}, LackOf(*kind, scene, index)};
      if (found.problem.empty()) {
        // All sensors only if nothing else is called so.
        if (index >= 0 || fitting.empty()) fitting.push_back(std::move(found));
      } else {
        lack = "'" + name + "'" + found.problem;
      }
    }
  }
  if (first == nullptr) return {{}, NothingCalled(name, object, scene)};
  if (fitting.size() > 1) {
    const auto word = [&](std::size_t i) {
      return std::string(renderer::ObjectWord(renderer::TraitsOf(fitting[i].parameter.kind).list));
    };
    return {{},
            "'" + name + "' could be that of a " + word(0) + " or of a " + word(1) +
                "; give them different names"};
  }
  if (fitting.size() == 1) return fitting.front();
  if (!lack.empty()) return {{}, lack};
  if (owners.empty()) owners = renderer::ObjectWord(first->list);
  return {{}, "no " + owners + " is called '" + object + "'" + NameHint(object, objects)};
}

}  // namespace pathfit::app
