#pragma once

#include <vector>

#include "optim/parameter/unknown_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// Values of the unknown beside the one that it has in `scene` from which a fit may end in another
/// valley, as they lie behind a pass that no step crosses. Of a constant metallic, unless a belief
/// says how large it is: dielectric and metal, within its bounds. A picture of the base colour
/// explains the photos that it is fitted to in either. Empty: there are none.
std::vector<double> OtherStarts(const renderer::Scene& scene,
                                const UnknownSpec& unknown,
                                const std::vector<UnknownSpec>& unknowns);

/// Scenes with an object, whose rotation is the unknown, turned by 20 degrees about each of the
/// world's axes, both ways, from which small photos may lead to another valley. None of other
/// unknowns, and where a belief says how it is turned.
std::vector<renderer::Scene> TurnedStarts(const renderer::Scene& scene, const UnknownSpec& unknown);

/// `scene` with that value of an unknown that has other starts.
renderer::Scene StartingAt(renderer::Scene scene, const UnknownSpec& unknown, double value);

/// The value that the scene has.
double StartOf(const renderer::Scene& scene, const UnknownSpec& unknown);

}  // namespace pathfit::optim
