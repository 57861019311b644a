#pragma once

#include <optional>
#include <vector>

#include "optim/observation/observation.h"

namespace pathfit::optim {

/// Masks of an object that was photographed from around, found without any.
struct ObjectMasks {
  std::vector<renderer::Image> masks;  ///< of each view: 1 channel, 0..1, size of its camera
  /// Mean overlap (intersection over union) of the masks with the silhouettes of the body that
  /// they have in common; 1: they tell of one body.
  double agreement = 0.0;
};

/// Tells the object from its background by colour in each photo and by what all photos say
/// together, in turns: the body that most of them call object says where each of them shall look
/// next (after [Campbell2007], voting instead of a volumetric cut).
/// It begins with the middle of a ball on which the cameras look: `centre`, `radius` in the units
/// of the cameras. Empty when the photos do not agree on a body: colours like the background's, a
/// background that is near on all sides, cameras that do not look at the object.
std::optional<ObjectMasks> MakeObjectMasks(const ObservationSet& observations,
                                           const renderer::Vec3& centre,
                                           double radius);

}  // namespace pathfit::optim
