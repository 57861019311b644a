#pragma once

#include <string>
#include <vector>

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

/// Names of all objects that have the property and fit the pattern, where one is given:
/// `lamp_*.rotation`; the name itself elsewhere, and where none fits.
std::vector<std::string> NamesLike(const renderer::Scene& scene, const std::string& name);

}  // namespace pathfit::app
