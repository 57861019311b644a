#pragma once

#include <optional>
#include <string>
#include <vector>

#include "renderer/render_options.h"
#include "renderer/scene/parameter_layout.h"

namespace pathfit::renderer {

/// What the derivative of a scene by these parameters leaves out, one sentence each, by the name of
/// the object that causes it; empty if it is complete. Said before rendering. `form`: the one that
/// is asked for, if any; else it is DefaultForm.
std::vector<std::string> DerivativeLimits(const Scene& scene,
                                          const ParameterLayout& layout,
                                          std::optional<DerivativeForm> form = std::nullopt);

/// The form that a derivative is taken in where none is asked for: that of the image, but where
/// cameras move and only the other one follows what they see (a line along which meshes cut each
/// other, the border of a projector's picture).
DerivativeForm DefaultForm(const Scene& scene, const ParameterLayout& layout);

/// Throws SceneError where a derivative cannot be had at all: material form with a mirror or glass,
/// whose surface points do not keep the light they reflect.
void CheckDerivative(const Scene& scene,
                     const ParameterLayout& layout,
                     const RenderOptions& options);

}  // namespace pathfit::renderer
