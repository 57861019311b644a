#pragma once

#include <optional>
#include <vector>

#include "renderer/geometry/mesh.h"
#include "renderer/sensor/camera.h"

namespace pathfit::optim {

/// The body on which sparse points lie, as structure from motion finds them beside cameras; all in
/// the frame and units of the cameras. Each point is a disc as wide as its neighbours are away,
/// facing the camera; what most cameras see discs before is inside (space carving by depth maps,
/// [Curless1996], of points). So gaps are closed that are as wide as those between points, and
/// the body is too large by parts of them: a start for a fit, not its shape.
/// Looked for in the ball about `centre` that the cameras look at: closed, manifold, outward
/// winding. Empty: there are too few points or cameras, they enclose nothing, or what they lie on
/// goes on beyond the ball (a room, or a table with a pattern).
std::optional<renderer::Mesh> BodyOfPoints(const std::vector<renderer::Vec3>& points,
                                           const std::vector<renderer::Camera>& cameras,
                                           const renderer::Vec3& centre,
                                           double radius);

}  // namespace pathfit::optim
