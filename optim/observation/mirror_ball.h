#pragma once

#include "renderer/image/image.h"
#include "renderer/math/vector.h"

namespace pathfit::optim {

/// A ball as it is seen from far away; pixel coordinates.
struct BallOutline {
  renderer::Vec2 centre;
  double radius = 0.0;
};

/// Of a mask, 1 = ball. Throws SceneError unless its largest part is nearly a disc.
BallOutline FindBall(const renderer::Image& mask);

/// Unit vector to the far lamp whose highlight a shiny ball shows: x right, y up, z to the viewer.
/// The normal at the highlight halves the angle between lamp and viewer. Of any picture of
/// brightness, linear or not. Throws SceneError where the ball has no highlight.
renderer::Vec3 LampOfHighlight(const renderer::Image& photo, const BallOutline& ball);

}  // namespace pathfit::optim
