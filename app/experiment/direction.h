#pragma once

#include <string>
#include <vector>

#include "renderer/scene/parameter_layout.h"

namespace pathfit::app {

/// A direction in which a scene can be changed: what `render --derivative` and `gradcheck`
/// differentiate by.
struct Direction {
  std::string name;
  renderer::ParameterLayout layout;  ///< one group (all sensors for exposure)
  std::vector<double> values;        ///< over the layout's scalars, per unit of the parameter
};

/// Directions by name:
///   OBJECT.PROPERTY           all scalars of the group: 1 for constants; for vertices, colors and
///   texels a fixed
///                             pseudo-random number in [-1, 1] each
///   OBJECT.PROPERTY.x|y|z|r|g|b   this component of all of them (vertices.x: the mesh moves along
///   x) MESH.vertices.scale       grows about the mean of its vertices, per relative scale
///   OBJECT.PROPERTY[i]        block i alone, and OBJECT.PROPERTY[i].x one scalar
///   exposure                  the gain of every sensor
/// Throws SceneError naming what does not exist.
Direction ParseDirection(const renderer::Scene& scene, const std::string& name);

/// Whether the object and property of a direction's name match a glob pattern.
bool MatchesGlob(const std::string& pattern, const std::string& name);

}  // namespace pathfit::app
