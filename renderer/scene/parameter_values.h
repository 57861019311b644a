#pragma once

#include <vector>

#include "renderer/scene/parameter_layout.h"

namespace pathfit::renderer {

/// Pointers to the scalars of a group inside a scene, in layout order.
std::vector<double*> ParameterScalars(Scene& scene, ParameterKind kind, int object);

}  // namespace pathfit::renderer
