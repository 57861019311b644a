#pragma once

#include "renderer/geometry/mesh.h"
#include "renderer/image/image.h"

namespace pathfit::optim {

/// A closed body that fills a silhouette like a cushion, alike in front and behind: what a shape
/// that is seen from one side can begin with. `mask`: 1 channel, 1 = object. x right, y up, z
/// to the viewer; the middle of the picture is the origin, a pixel is `pixel` long. Seen along z,
/// its outline is that of the mask's largest part to about a hundredth of its size; a disc becomes
/// `depth` times as thick as it is wide. Throws SceneError if the mask is empty.
renderer::Mesh MakeCushion(const renderer::Image& mask, double pixel, double depth);

}  // namespace pathfit::optim
