#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/config/experiment_config.h"
#include "optim/observation/observation.h"
#include "renderer/scene/scene.h"

namespace pathfit::app {

/// What building reads besides the configuration, and what it leaves behind.
struct BuildContext {
  const optim::ObservationSet& observations;  ///< visual hulls are carved from them
  std::vector<std::filesystem::path>& files;  ///< every file that was read is appended
  std::vector<std::string>& notes;            ///< what was mended, for people
};

inline renderer::Vec3 ToVec3(const Triple& t) { return {t[0], t[1], t[2]}; }
inline renderer::Rgb ToRgb(const Triple& t) { return {t[0], t[1], t[2]}; }
renderer::Mat3 RotationOf(const Triple& axis, double angle);

// Objects of a scene from their part of the configuration. Names are resolved to indices into the
// lists of `config`, which are those of the scene. Throw IoError and SceneError naming the object.

/// The meshes of one geometry entry, in the world frame: one, or one for each group of the file
/// that has a material of its own. Poses are the identity about the entry's pivot, by default
/// the middle of the bounding box of all of them.
std::vector<renderer::SceneMesh> BuildMeshes(const GeometryConfig& geometry,
                                             const ExperimentConfig& config,
                                             const BuildContext& context);

renderer::Texture BuildTexture(const TextureConfig& texture, const BuildContext& context);
renderer::Material BuildMaterial(const MaterialConfig& material, const ExperimentConfig& config);

/// `scene` has its meshes and textures already.
renderer::Emitter BuildEmitter(const LightConfig& light,
                               const renderer::Scene& scene,
                               const BuildContext& context);

renderer::Camera BuildSensor(const SensorConfig& sensor);

}  // namespace pathfit::app
