#pragma once

#include <string>
#include <vector>

#include "renderer/scene/scene.h"

namespace pathfit::app {

/// A Python script for Blender (3.4 and later) that stands beside the scene's GLB files and
/// environment.exr and sets up a scene from them: meshes with their materials, one camera per
/// sensor, frame i of the timeline being the picture of sensor i - 1 with its exposure, and the
/// lights, turned as the fit had them, with those that go with the camera following it. Run
/// `blender --python FILE`, or in the background with `-- --render FRAME PICTURE.exr`.
/// `mesh_files`: of each mesh, in the scene's order; `max_bounces`: of paths, 1 = direct light. Our
/// world's y is Blender's z, as in its glTF import.
std::string BlenderScript(const renderer::Scene& scene,
                          const std::vector<std::string>& mesh_files,
                          int max_bounces);

/// What the script leaves out of this scene, in sentences for people.
std::vector<std::string> BlenderGaps(const renderer::Scene& scene);

}  // namespace pathfit::app
