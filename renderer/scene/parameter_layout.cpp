#include "renderer/scene/parameter_layout.h"

#include <algorithm>

#include "renderer/core/check.h"
#include "renderer/core/error.h"

namespace pathfit::renderer {
namespace {

const char* PropertyName(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::kVertexPositions:
      return "vertices";
    case ParameterKind::kVertexColors:
      return "colors";
    case ParameterKind::kBaseColor:
      return "base_color";
    case ParameterKind::kRoughness:
      return "roughness";
    case ParameterKind::kMetallic:
      return "metallic";
    case ParameterKind::kLightIntensity:
      return "intensity";
    case ParameterKind::kEnvironmentTexels:
      return "texels";
    case ParameterKind::kExposure:
      return "exposure";
  }
  return "?";
}

bool IsScalar(ParameterKind kind) {
  return kind == ParameterKind::kRoughness || kind == ParameterKind::kMetallic ||
         kind == ParameterKind::kExposure;
}

/// Calls visit(double&) for every scalar of a group, in layout order. `scene` may be const.
template <class S, class Visit>
void ForEachScalar(S& scene, const ParameterGroup& group, Visit visit) {
  const auto index = static_cast<std::size_t>(group.object);
  const auto triples = [&](auto& list) {
    for (auto& item : list) {
      for (int c = 0; c < 3; ++c) visit(item[c]);
    }
  };
  const auto rgb = [&](auto& color) {
    for (int c = 0; c < 3; ++c) visit(color[c]);
  };
  switch (group.kind) {
    case ParameterKind::kVertexPositions:
      return triples(scene.meshes[index].mesh.positions);
    case ParameterKind::kVertexColors:
      return triples(scene.meshes[index].mesh.colors);
    case ParameterKind::kBaseColor:
      return rgb(scene.materials[index].base_color);
    case ParameterKind::kRoughness:
      return visit(std::get<MetallicRoughnessBsdf>(scene.materials[index].bsdf).roughness);
    case ParameterKind::kMetallic:
      return visit(std::get<MetallicRoughnessBsdf>(scene.materials[index].bsdf).metallic);
    case ParameterKind::kLightIntensity:
      return rgb(LightIntensity(scene.emitters[index]));
    case ParameterKind::kEnvironmentTexels:
      return triples(std::get<EnvironmentEmitter>(scene.emitters[index].light).texels);
    case ParameterKind::kExposure:
      return visit(scene.sensors[index].gain);
  }
}

}  // namespace

ParameterLayout::ParameterLayout(const Scene& scene) {
  for (const SceneMesh& m : scene.meshes) {
    sizes_.meshes.push_back(m.name);
    sizes_.positions.push_back(static_cast<std::int32_t>(m.mesh.positions.size()));
    sizes_.colors.push_back(static_cast<std::int32_t>(m.mesh.colors.size()));
  }
  for (const Material& m : scene.materials) {
    sizes_.materials.push_back(m.name);
    sizes_.rough.push_back(std::holds_alternative<MetallicRoughnessBsdf>(m.bsdf));
  }
  for (const Emitter& e : scene.emitters) {
    sizes_.emitters.push_back(e.name);
    const auto* environment = std::get_if<EnvironmentEmitter>(&e.light);
    sizes_.texels.push_back(
        environment != nullptr ? static_cast<std::int32_t>(environment->texels.size()) : 0);
  }
  for (const PerspectiveCamera& c : scene.sensors) {
    sizes_.sensors.push_back(c.name);
  }
}

void ParameterLayout::Add(ParameterKind kind, int object) {
  const auto at = [&](const auto& list) {
    if (object < 0 || static_cast<std::size_t>(object) >= list.size()) {
      throw SceneError(std::string("no object ") + std::to_string(object) + " with parameter '" +
                       PropertyName(kind) + "'");
    }
    return list[static_cast<std::size_t>(object)];
  };
  ParameterGroup group;
  group.kind = kind;
  group.object = object;
  group.num_blocks = 1;
  switch (kind) {
    case ParameterKind::kVertexPositions:
      group.name = at(sizes_.meshes);
      group.num_blocks = at(sizes_.positions);
      break;
    case ParameterKind::kVertexColors:
      group.name = at(sizes_.meshes);
      group.num_blocks = at(sizes_.colors);
      break;
    case ParameterKind::kBaseColor:
      group.name = at(sizes_.materials);
      break;
    case ParameterKind::kRoughness:
    case ParameterKind::kMetallic:
      group.name = at(sizes_.materials);
      group.num_blocks = at(sizes_.rough) ? 1 : 0;
      break;
    case ParameterKind::kLightIntensity:
      group.name = at(sizes_.emitters);
      break;
    case ParameterKind::kEnvironmentTexels:
      group.name = at(sizes_.emitters);
      group.num_blocks = at(sizes_.texels);
      break;
    case ParameterKind::kExposure:
      group.name = at(sizes_.sensors);
      break;
  }
  group.name += std::string(".") + PropertyName(kind);
  if (group.num_blocks == 0) {
    throw SceneError("'" + group.name + "' does not exist in this scene");
  }
  if (FirstBlock(kind, object) >= 0) {
    throw SceneError("'" + group.name + "' is listed twice");
  }
  group.block_size = IsScalar(kind) ? 1 : 3;
  group.first_block = num_blocks_;
  group.first_scalar = num_scalars_;
  num_blocks_ += group.num_blocks;
  num_scalars_ += static_cast<std::int64_t>(group.num_blocks) * group.block_size;
  groups_.push_back(group);
}

std::int32_t ParameterLayout::FirstBlock(ParameterKind kind, int object) const {
  const auto found = std::find_if(groups_.begin(), groups_.end(), [&](const auto& g) {
    return g.kind == kind && g.object == object;
  });
  return found == groups_.end() ? -1 : found->first_block;
}

const ParameterGroup& ParameterLayout::GroupOfBlock(std::int32_t block) const {
  PATHFIT_CHECK(block >= 0 && block < num_blocks_);
  const auto above =
      std::upper_bound(groups_.begin(), groups_.end(), block, [](std::int32_t b, const auto& g) {
        return b < g.first_block;
      });
  return *std::prev(above);
}

std::int64_t ParameterLayout::FirstScalarOfBlock(std::int32_t block) const {
  const ParameterGroup& group = GroupOfBlock(block);
  return group.first_scalar +
         static_cast<std::int64_t>(block - group.first_block) * group.block_size;
}

std::string ParameterLayout::ScalarName(std::int32_t block, int component) const {
  const ParameterGroup& group = GroupOfBlock(block);
  std::string name = group.name;
  if (group.num_blocks > 1) {
    name += "[" + std::to_string(block - group.first_block) + "]";
  }
  if (group.block_size == 3) {
    const bool vertices = group.kind == ParameterKind::kVertexPositions;
    name += std::string(".") + (vertices ? "xyz" : "rgb")[component];
  }
  return name;
}

std::vector<double> ParameterLayout::Gather(const Scene& scene) const {
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(num_scalars_));
  for (const ParameterGroup& group : groups_) {
    ForEachScalar(scene, group, [&](const double& x) { values.push_back(x); });
  }
  PATHFIT_CHECK(values.size() == static_cast<std::size_t>(num_scalars_));
  return values;
}

void ParameterLayout::Scatter(const std::vector<double>& values, Scene& scene) const {
  PATHFIT_CHECK(values.size() == static_cast<std::size_t>(num_scalars_));
  std::size_t next = 0;
  for (const ParameterGroup& group : groups_) {
    ForEachScalar(scene, group, [&](double& x) { x = values[next++]; });
  }
}

}  // namespace pathfit::renderer
