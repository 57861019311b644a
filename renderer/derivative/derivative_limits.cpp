#include "renderer/derivative/derivative_limits.h"

#include <algorithm>

#include "renderer/core/error.h"

namespace pathfit::renderer {
namespace {

bool AnyMoves(const ParameterLayout& layout) {
  const auto& groups = layout.groups();
  return std::any_of(
      groups.begin(), groups.end(), [](const auto& g) { return MovesGeometry(g.kind); });
}

/// Meshes made of a delta material.
std::vector<std::string> DeltaMeshes(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneMesh& m : scene.meshes) {
    if (IsDelta(scene.materials[static_cast<std::size_t>(m.material)].bsdf)) {
      names.push_back(m.name);
    }
  }
  return names;
}

}  // namespace

bool MovesGeometry(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::kVertexPositions:
    case ParameterKind::kVertexNormals:
    case ParameterKind::kUvs:
    case ParameterKind::kObjectTranslation:
    case ParameterKind::kObjectRotation:
    case ParameterKind::kObjectScale:
    case ParameterKind::kLightPosition:
    case ParameterKind::kLightRotation:
    case ParameterKind::kCameraPosition:
    case ParameterKind::kCameraRotation:
    case ParameterKind::kFocal:
    case ParameterKind::kPrincipalPoint:
    case ParameterKind::kRadialDistortion:
    case ParameterKind::kTangentialDistortion:
      return true;
    case ParameterKind::kVertexColors:
    case ParameterKind::kBaseColor:
    case ParameterKind::kRoughness:
    case ParameterKind::kMetallic:
    case ParameterKind::kEta:
    case ParameterKind::kExtinction:
    case ParameterKind::kTextureTexels:
    case ParameterKind::kLightIntensity:
    case ParameterKind::kSpotAngles:
    case ParameterKind::kEnvironmentTexels:
    case ParameterKind::kExposure:
      return false;
  }
  return false;
}

std::vector<std::string> DerivativeLimits(const Scene& scene, const ParameterLayout& layout) {
  std::vector<std::string> limits;
  if (!AnyMoves(layout)) {
    return limits;
  }
  for (const std::string& name : DeltaMeshes(scene)) {
    limits.push_back("'" + name +
                     "' is a mirror or smooth glass: what is seen in it follows moving things, but "
                     "edges seen in it, and light and shadows that reach rough surfaces through "
                     "it, are not in the derivative by moving things");
  }
  for (const Emitter& emitter : scene.emitters) {
    const auto* projector = std::get_if<ProjectorEmitter>(&emitter.light);
    if (projector != nullptr) {
      limits.push_back("'" + emitter.name +
                       "' is a projector: the border of its picture is not in the derivative by "
                       "moving things; it does not matter where the picture is black there");
    }
  }
  return limits;
}

void CheckDerivative(const Scene& scene,
                     const ParameterLayout& layout,
                     const RenderOptions& options) {
  if (options.form != DerivativeForm::kMaterial || !AnyMoves(layout)) {
    return;
  }
  const std::vector<std::string> names = DeltaMeshes(scene);
  if (!names.empty()) {
    throw SceneError("'" + names.front() +
                     "' is a mirror or smooth glass: its points do not keep what they reflect, so "
                     "the material form has no derivative; use the image form");
  }
}

}  // namespace pathfit::renderer
