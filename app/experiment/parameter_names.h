#pragma once

#include <string>

#include "renderer/scene/parameter_kinds.h"

namespace pathfit::app {

/// What OBJECT.PROPERTY stands for in a scene. `camera` stands for all sensors unless something
/// with this property is called so.
struct ParameterName {
  renderer::ParameterRef parameter;
  /// Why it names nothing that could change the picture, with a hint of what was meant; or empty.
  std::string problem;
};
ParameterName FindParameter(const renderer::Scene& scene, const std::string& name);

}  // namespace pathfit::app
