#pragma once

#include <string>

#include "renderer/scene/scene.h"

namespace pathfit::bench {

/// Closed box [-1,1]^3 open towards the sensor with two blocks inside, lit by a point lamp: deep
/// paths.
renderer::Scene BoxScene();

/// A mesh of about 80 000 triangles on a floor under a constant environment: shallow paths, a large
/// tree. `mesh` replaces the built-in bumpy ball if it is not empty; it is scaled to fit.
renderer::Scene MeshOnFloorScene(const renderer::Mesh& mesh);

}  // namespace pathfit::bench
