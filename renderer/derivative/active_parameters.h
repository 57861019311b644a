#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/parameter_layout.h"

namespace pathfit::renderer {

/// First block of every parameter group by object, -1 where it is not active: what the estimators
/// look up per sample.
struct ActiveParameters {
  std::vector<std::int32_t> positions, colors;                ///< by mesh
  std::vector<std::int32_t> base_color, roughness, metallic;  ///< by material
  std::vector<std::int32_t> intensity, texels;                ///< by emitter
  std::int32_t exposure = -1;                                 ///< of the sensor being rendered
  bool any_positions = false;
  bool any_material = false;  ///< base colours, vertex colours, roughness or metallic

  static ActiveParameters Make(const Scene& scene, const ParameterLayout& layout, int sensor);
};

}  // namespace pathfit::renderer
