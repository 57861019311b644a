#include "renderer/derivative/active_parameters.h"

#include <algorithm>

namespace pathfit::renderer {

ActiveParameters ActiveParameters::Make(const Scene& scene,
                                        const ParameterLayout& layout,
                                        int sensor) {
  const auto blocks = [&](ParameterKind kind, std::size_t count) {
    std::vector<std::int32_t> first(count);
    for (std::size_t i = 0; i < count; ++i) {
      first[i] = layout.FirstBlock(kind, static_cast<int>(i));
    }
    return first;
  };
  const auto any = [](const std::vector<std::int32_t>& first) {
    return std::any_of(first.begin(), first.end(), [](std::int32_t b) { return b >= 0; });
  };
  ActiveParameters active;
  active.positions = blocks(ParameterKind::kVertexPositions, scene.meshes.size());
  active.colors = blocks(ParameterKind::kVertexColors, scene.meshes.size());
  active.base_color = blocks(ParameterKind::kBaseColor, scene.materials.size());
  active.roughness = blocks(ParameterKind::kRoughness, scene.materials.size());
  active.metallic = blocks(ParameterKind::kMetallic, scene.materials.size());
  active.intensity = blocks(ParameterKind::kLightIntensity, scene.emitters.size());
  active.texels = blocks(ParameterKind::kEnvironmentTexels, scene.emitters.size());
  active.exposure = sensor >= 0 ? layout.FirstBlock(ParameterKind::kExposure, sensor) : -1;
  active.any_positions = any(active.positions);
  active.any_material =
      any(active.colors) || any(active.base_color) || any(active.roughness) || any(active.metallic);
  return active;
}

}  // namespace pathfit::renderer
