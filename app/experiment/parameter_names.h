#pragma once

#include <string>

#include "renderer/scene/parameter_layout.h"

namespace pathfit::app {

/// A group of parameters of a scene.
struct ParameterRef {
  renderer::ParameterKind kind = renderer::ParameterKind::kVertexPositions;
  int object = 0;  ///< -1: every sensor
};

/// Looks up OBJECT.PROPERTY. `camera` stands for all sensors unless something with this property is
/// called so. Throws SceneError: no such property, object, or one that the object lacks; two that
/// could be meant.
ParameterRef FindParameter(const renderer::Scene& scene,
                           const std::string& object,
                           const std::string& property);

/// Adds the group, of every sensor for object -1. Throws SceneError.
void AddParameter(const ParameterRef& parameter,
                  const renderer::Scene& scene,
                  renderer::ParameterLayout& layout);

}  // namespace pathfit::app
