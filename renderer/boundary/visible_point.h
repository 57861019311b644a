#pragma once

#include <optional>

#include "renderer/boundary/boundary_technique.h"

namespace pathfit::renderer {

/// Whether the interior estimator keeps what a sensor ray meets at its place in the image: always
/// in image form; in material form the environment of an orthographic camera, one direction of
/// which fills the image. No hit: environment.
bool IsInImageForm(const BoundaryContext& context, const std::optional<Hit>& hit);

/// Whether the environment turns, so that its points move in the image.
bool SkyMoves(const BoundaryContext& context);

/// Adds the gradient of m . u', u' the image velocity of the material point that sensor ray `ray`
/// meets, to `row`. The environment's point is a direction that turns with the light. `m`: pixels.
void AddMotionOfVisiblePoint(const BoundaryContext& context,
                             const std::optional<Hit>& hit,
                             const Ray& ray,
                             const Vec2& m,
                             MotionRow& row);

}  // namespace pathfit::renderer
