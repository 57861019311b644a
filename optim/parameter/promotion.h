#pragma once

#include <vector>

#include "optim/parameter/unknown_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// Whether another unknown's numbers stand for the same property in this scene: those of a constant
/// where there is a texture by now, of texels where there is none yet. Only of properties that some
/// unknown of `unknowns` promotes; the scene has no such parameter then, or it is of no effect.
bool IsReplaced(const renderer::Scene& scene,
                const UnknownSpec& unknown,
                const std::vector<UnknownSpec>& unknowns);

}  // namespace pathfit::optim
