#pragma once

#include <string>
#include <vector>

#include "renderer/render_options.h"
#include "renderer/scene/parameter_layout.h"

namespace pathfit::renderer {

/// What the derivative of a scene by these parameters leaves out, one sentence each, by the name of
/// the object that causes it; empty if it is complete. Said before rendering.
std::vector<std::string> DerivativeLimits(const Scene& scene, const ParameterLayout& layout);

/// Throws SceneError where a derivative cannot be had at all: material form with a mirror or glass,
/// whose surface points do not keep the light they reflect.
void CheckDerivative(const Scene& scene,
                     const ParameterLayout& layout,
                     const RenderOptions& options);

}  // namespace pathfit::renderer
