#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/scene/parameter_layout.h"
#include "renderer/scene/scene.h"

namespace pathfit::bench {

/// A scene of the side-by-side benchmark and the one number it is differentiated by.
struct PeerCase {
  std::string name;
  renderer::Scene scene;  ///< one sensor of 128 x 128 pixels, box filter
  int max_bounces = 1;
  int mover = 0;  ///< the mesh that moves
  renderer::ParameterKind kind = renderer::ParameterKind::kObjectTranslation;
  renderer::Vec3 direction;              ///< change of the parameter's block per unit of the number
  double finite_difference_step = 2e-3;  ///< in units of the number; both sides together
};

/// soft_shadow, bunny_direct, bunny_two_bounces, bunny_constant_sky, cornell_four_bounces.
std::vector<std::string> PeerCaseNames();

/// The case built from the mesh files in `meshes`. Surfaces reflect on the side of their normals
/// only, as the peer's do. The number is a translation along x in scene units, or for the bunny a
/// rotation about the world's y axis in degrees. Fails: IoError, std::invalid_argument for other
/// names.
PeerCase MakePeerCase(const std::string& name, const std::filesystem::path& meshes);

}  // namespace pathfit::bench
