#include "app/experiment/direction.h"

#include <array>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include <fnmatch.h>

#include "renderer/core/error.h"
#include "renderer/sampler/counter_rng.h"

namespace pathfit::app {
namespace {

using renderer::ParameterGroup;
using renderer::ParameterKind;
using renderer::ParameterLayout;
using renderer::SceneError;

constexpr std::array<std::pair<const char*, ParameterKind>, 7> kProperties = {{
    {"vertices", ParameterKind::kVertexPositions},
    {"colors", ParameterKind::kVertexColors},
    {"base_color", ParameterKind::kBaseColor},
    {"roughness", ParameterKind::kRoughness},
    {"metallic", ParameterKind::kMetallic},
    {"intensity", ParameterKind::kLightIntensity},
    {"texels", ParameterKind::kEnvironmentTexels},
}};
constexpr std::uint64_t kDirectionDomain = 100;

struct ParsedName {
  std::string object, property;
  std::optional<std::int32_t> index;
  std::optional<int> component;
};

[[noreturn]] void Fail(const std::string& name, const std::string& what) {
  throw SceneError("parameter '" + name + "': " + what);
}

ParsedName Parse(const std::string& name) {
  ParsedName parsed;
  const std::size_t dot = name.find('.');
  if (dot == std::string::npos) {
    Fail(name, "expected OBJECT.PROPERTY, for example axe.vertices.x");
  }
  parsed.object = name.substr(0, dot);
  std::string rest = name.substr(dot + 1);
  if (rest.size() > 2 && rest[rest.size() - 2] == '.') {
    const char letter = rest.back();
    const std::string letters = "xyzrgb";
    const std::size_t at = letters.find(letter);
    if (at == std::string::npos) {
      Fail(name, "the component must be one of x, y, z, r, g, b");
    }
    parsed.component = static_cast<int>(at % 3);
    rest.resize(rest.size() - 2);
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
  parsed.property = rest;
  return parsed;
}

template <class List>
int IndexOf(const List& list, const std::string& object, const std::string& name) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].name == object) {
      return static_cast<int>(i);
    }
  }
  std::string known;
  for (const auto& item : list) {
    known += (known.empty() ? "" : ", ") + item.name;
  }
  Fail(name, "no '" + object + "' with this property (known: " + known + ")");
}

int ObjectIndex(const renderer::Scene& scene,
                ParameterKind kind,
                const std::string& object,
                const std::string& name) {
  switch (kind) {
    case ParameterKind::kVertexPositions:
    case ParameterKind::kVertexColors:
      return IndexOf(scene.meshes, object, name);
    case ParameterKind::kBaseColor:
    case ParameterKind::kRoughness:
    case ParameterKind::kMetallic:
      return IndexOf(scene.materials, object, name);
    default:
      return IndexOf(scene.emitters, object, name);
  }
}

Direction AllExposures(const renderer::Scene& scene) {
  Direction direction{"exposure", ParameterLayout(scene), {}};
  for (std::size_t i = 0; i < scene.sensors.size(); ++i) {
    direction.layout.Add(ParameterKind::kExposure, static_cast<int>(i));
  }
  direction.values.assign(scene.sensors.size(), 1.0);
  return direction;
}

constexpr std::string_view kScaleSuffix = ".vertices.scale";

Direction ScaleOfMesh(const renderer::Scene& scene, const std::string& name) {
  const std::string object = name.substr(0, name.size() - kScaleSuffix.size());
  const int mesh = IndexOf(scene.meshes, object, name);
  Direction direction{name, ParameterLayout(scene), {}};
  direction.layout.Add(ParameterKind::kVertexPositions, mesh);
  const auto& positions = scene.meshes[static_cast<std::size_t>(mesh)].mesh.positions;
  renderer::Vec3 mean;
  for (const renderer::Vec3& p : positions) {
    mean += p / static_cast<double>(positions.size());
  }
  for (const renderer::Vec3& p : positions) {
    const renderer::Vec3 velocity = p - mean;
    direction.values.insert(direction.values.end(), {velocity.x, velocity.y, velocity.z});
  }
  return direction;
}

}  // namespace

Direction ParseDirection(const renderer::Scene& scene, const std::string& name) {
  if (name == "exposure") {
    return AllExposures(scene);
  }
  if (name.ends_with(kScaleSuffix)) {
    return ScaleOfMesh(scene, name);
  }
  const ParsedName parsed = Parse(name);
  const std::pair<const char*, ParameterKind>* property = nullptr;
  for (const auto& candidate : kProperties) {
    if (parsed.property == candidate.first) {
      property = &candidate;
    }
  }
  if (property == nullptr) {
    Fail(name,
         "no property '" + parsed.property +
             "' (known: vertices, colors, base_color, roughness, metallic, intensity, texels)");
  }
  Direction direction{name, ParameterLayout(scene), {}};
  direction.layout.Add(property->second, ObjectIndex(scene, property->second, parsed.object, name));
  const ParameterGroup& group = direction.layout.groups().front();
  if (parsed.component && group.block_size == 1) {
    Fail(name, "this property is a single number, without components");
  }
  if (parsed.index && *parsed.index >= group.num_blocks) {
    Fail(name, "the index must be below " + std::to_string(group.num_blocks));
  }
  const bool whole_field = group.num_blocks > 1 && !parsed.index && !parsed.component;
  direction.values.assign(static_cast<std::size_t>(direction.layout.NumScalars()), 0.0);
  renderer::CounterRng rng(0, kDirectionDomain, 0, 0, 0);
  for (std::int32_t block = 0; block < group.num_blocks; ++block) {
    for (int c = 0; c < group.block_size; ++c) {
      const double random = 2.0 * rng.Next() - 1.0;
      const bool chosen = (!parsed.index || *parsed.index == block) &&
                          (!parsed.component || *parsed.component == c);
      if (chosen) {
        direction.values[static_cast<std::size_t>(block * group.block_size + c)] =
            whole_field ? random : 1.0;
      }
    }
  }
  return direction;
}

bool MatchesGlob(const std::string& pattern, const std::string& name) {
  return fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
}

}  // namespace pathfit::app
