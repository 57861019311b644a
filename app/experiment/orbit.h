#pragma once

#include <vector>

#include "renderer/scene/scene.h"

namespace pathfit::app {

/// The direction that the scene's cameras hold up, unit: across all of their x axes, as on a tripod
/// or in steady hands, towards the mean of their y axes; that mean itself where the x axes do not
/// tell; +y without cameras. Within two degrees of an axis of the world it is that axis.
renderer::Vec3 UpDirection(const renderer::Scene& scene);

/// `count` cameras on a circle about the scene's meshes, one after the other against the clock seen
/// from above: at the mean height and distance of the scene's cameras, farther where the meshes
/// would not fit into the picture, beginning at the first camera's side. Size, focal length and
/// lamps are the first camera's, with square pixels, no distortion, the middle in the middle, and
/// the mean exposure. Throws SceneError without meshes or cameras.
std::vector<renderer::Camera> OrbitCameras(const renderer::Scene& scene, int count);

}  // namespace pathfit::app
