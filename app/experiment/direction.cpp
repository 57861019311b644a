#include "app/experiment/direction.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "app/experiment/parameter_names.h"
#include "renderer/core/error.h"
#include "renderer/sampler/counter_rng.h"

namespace pathfit::app {
namespace {

using renderer::ParameterGroup;
using renderer::ParameterKind;
using renderer::ParameterLayout;
using renderer::ParameterRef;
using renderer::SceneError;

struct ParsedName {
  std::string object, property;
  std::optional<std::int32_t> index;
  std::optional<char> component;
};

[[noreturn]] void Fail(const std::string& name, const std::string& what) {
  throw SceneError("parameter '" + name + "': " + what);
}

// From the end: objects may have dots in their names (photos), properties have none.
ParsedName Parse(const std::string& name) {
  ParsedName parsed;
  std::string rest = name;
  // A single letter is a component, unless only the object is left: gold.k, gold.k.r.
  const std::size_t before = rest.size() > 2 ? rest.size() - 2 : 0;
  if (before > 0 && rest[before] == '.' && rest.find('.') < before) {
    parsed.component = rest.back();
    rest.resize(before);
  }
  if (!rest.empty() && rest.back() == ']') {
    const std::size_t open = rest.find('[');
    std::int32_t index = -1;
    if (open == std::string::npos ||
        std::from_chars(rest.data() + open + 1, rest.data() + rest.size() - 1, index).ptr !=
            rest.data() + rest.size() - 1 ||
        index < 0) {
      Fail(name, "expected a whole number in the brackets");
    }
    parsed.index = index;
    rest.resize(open);
  }
  const std::size_t dot = rest.rfind('.');
  if (dot == std::string::npos) Fail(name, "expected OBJECT.PROPERTY, for example axe.vertices.x");
  parsed.object = rest.substr(0, dot);
  parsed.property = rest.substr(dot + 1);
  return parsed;
}

ParameterRef Find(const renderer::Scene& scene, const ParsedName& parsed, const std::string& name) {
  const ParameterName found = FindParameter(scene, parsed.object + "." + parsed.property);
  if (!found.problem.empty()) Fail(name, found.problem);
  return found.parameter;
}

// Blocks whose components have no sum that means something.
bool NeedsComponent(const ParameterGroup& group) {
  return group.num_blocks == 1 && std::string_view(group.components) == "xyz";
}

std::optional<int> FindComponent(const ParsedName& parsed,
                                 const ParameterGroup& group,
                                 const std::string& name) {
  const std::string letters = group.components;
  std::string list;
  for (const char letter : letters) list += (list.empty() ? "" : ", ") + std::string(1, letter);
  if (!parsed.component) {
    if (NeedsComponent(group)) Fail(name, "a component is needed behind it: one of " + list);
    return std::nullopt;
  }
  if (letters.empty()) Fail(name, "this property is a single number, without components");
  const std::size_t at = letters.find(*parsed.component);
  if (at == std::string::npos) Fail(name, "the component must be one of " + list);
  return static_cast<int>(at);
}

/// Of all sensors at once: kind and place among its numbers.
struct SensorsDirection {
  const char* unknown;
  const char* name;
  ParameterKind kind;
  std::size_t component;
};
constexpr SensorsDirection kOfAllSensors[] = {
    {"exposure", "exposure", ParameterKind::kExposure, 0},
    {"white_balance", "white_balance.r", ParameterKind::kWhiteBalance, 0},
    {"white_balance", "white_balance.b", ParameterKind::kWhiteBalance, 1}};

Direction OfAllSensors(const renderer::Scene& scene, const SensorsDirection& which) {
  Direction direction{which.name, ParameterLayout(scene), {}};
  direction.layout.Add(which.kind, -1);
  direction.values.assign(static_cast<std::size_t>(direction.layout.NumScalars()), 0.0);
  const std::size_t size = direction.values.size() / std::max<std::size_t>(1, scene.sensors.size());
  for (std::size_t i = which.component; i < direction.values.size(); i += size) {
    direction.values[i] = 1.0;
  }
  return direction;
}

constexpr std::string_view kScaleSuffix = ".vertices.scale";

Direction ScaleOfVertices(const renderer::Scene& scene, const std::string& name) {
  const ParsedName parsed{
      name.substr(0, name.size() - kScaleSuffix.size()), "vertices", std::nullopt, std::nullopt};
  const ParameterRef parameter = Find(scene, parsed, name);
  Direction direction{name, ParameterLayout(scene), {}};
  direction.layout.Add(parameter.kind, parameter.object);
  const auto& positions = scene.meshes[static_cast<std::size_t>(parameter.object)].mesh.positions;
  renderer::Vec3 mean;
  for (const renderer::Vec3& p : positions) mean += p / static_cast<double>(positions.size());
  for (const renderer::Vec3& p : positions) {
    const renderer::Vec3 velocity = p - mean;
    direction.values.insert(direction.values.end(), {velocity.x, velocity.y, velocity.z});
  }
  return direction;
}

// Values of one group, written from its first scalar on.
void SetValues(const ParsedName& parsed,
               std::optional<int> component,
               const ParameterGroup& group,
               FieldDirection field,
               std::vector<double>& values) {
  const bool is_random =
      field == FieldDirection::kRandom && group.num_blocks > 1 && !parsed.index && !component;
  renderer::CounterRng rng(0, renderer::RandomDomain::kFieldDirection);
  for (std::int32_t block = 0; block < group.num_blocks; ++block) {
    for (int c = 0; c < group.block_size; ++c) {
      const double random = 2.0 * rng.Next() - 1.0;
      const bool chosen =
          (!parsed.index || *parsed.index == block) && (!component || *component == c);
      if (chosen) {
        values[static_cast<std::size_t>(group.first_scalar + block * group.block_size + c)] =
            is_random ? random : 1.0;
      }
    }
  }
}

}  // namespace

Direction ParseDirection(const renderer::Scene& scene,
                         const std::string& name,
                         FieldDirection field) {
  for (const SensorsDirection& which : kOfAllSensors) {
    if (name == which.name) return OfAllSensors(scene, which);
  }
  if (name.ends_with(kScaleSuffix)) return ScaleOfVertices(scene, name);
  const ParsedName parsed = Parse(name);
  const ParameterRef parameter = Find(scene, parsed, name);
  Direction direction{name, ParameterLayout(scene), {}};
  direction.layout.Add(parameter.kind, parameter.object);
  direction.values.assign(static_cast<std::size_t>(direction.layout.NumScalars()), 0.0);
  for (const ParameterGroup& group : direction.layout.groups()) {
    const std::optional<int> component = FindComponent(parsed, group, name);
    if (parsed.index && *parsed.index >= group.num_blocks) {
      Fail(name, "the index must be below " + std::to_string(group.num_blocks));
    }
    SetValues(parsed, component, group, field, direction.values);
  }
  return direction;
}

std::vector<std::string> DirectionNames(const renderer::Scene& scene, const std::string& unknown) {
  std::vector<std::string> of_all_sensors;
  for (const SensorsDirection& which : kOfAllSensors) {
    if (unknown == which.unknown) of_all_sensors.emplace_back(which.name);
  }
  if (!of_all_sensors.empty()) return of_all_sensors;
  const ParsedName parsed = Parse(unknown);
  const ParameterRef parameter = Find(scene, parsed, unknown);
  ParameterLayout layout(scene);
  layout.Add(parameter.kind, parameter.object);
  const ParameterGroup& group = layout.groups().front();
  if (parsed.component || !NeedsComponent(group)) return {unknown};
  std::vector<std::string> names;
  for (const char letter : std::string_view(group.components)) {
    names.push_back(unknown + "." + letter);
  }
  return names;
}

}  // namespace pathfit::app
