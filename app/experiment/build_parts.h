#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
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
  std::vector<std::string>& warnings;         ///< what of a file is not used
};

template <class List>
bool HasName(const List& list, const std::string& name) {
  return std::any_of(list.begin(), list.end(), [&](const auto& item) { return item.name == name; });
}

inline renderer::Vec3 ToVec3(const Triple& t) { return {t[0], t[1], t[2]}; }
inline renderer::Rgb ToRgb(const Triple& t) { return {t[0], t[1], t[2]}; }
renderer::Mat3 RotationOf(const Triple& axis, double angle);

// Objects of a scene from their part of the configuration. Names are resolved to indices into the
// lists of `config`, which are those of the scene. Throw IoError and SceneError naming the object.

/// Adds the meshes of one geometry entry, in the world frame: one, or one for each group of the
/// file that has a material of its own. Poses are the identity about the entry's pivot, by default
/// the middle of the bounding box of all of them. What else a glTF file brings comes along:
/// materials, textures, lights and cameras.
void AddMeshes(const GeometryConfig& geometry,
               const ExperimentConfig& config,
               const BuildContext& context,
               renderer::Scene& scene);

/// A mesh to be, in the frame of its file.
struct MeshPart {
  std::string name;
  int material = 0;  ///< in the scene, whose first ones are those of the configuration
  renderer::Mesh mesh;
  std::optional<renderer::AreaEmitter> emission;
};

/// The meshes of a glTF file. Adds those of its materials and textures that they use, and if wanted
/// its lights and cameras, placed by `world_from_file`.
std::vector<MeshPart> ReadGltfParts(const GeometryConfig& geometry,
                                    const ExperimentConfig& config,
                                    const BuildContext& context,
                                    const renderer::Transform& world_from_file,
                                    renderer::Scene& scene);

renderer::Texture BuildTexture(const TextureConfig& texture, const BuildContext& context);
renderer::Material BuildMaterial(const MaterialConfig& material, const ExperimentConfig& config);

/// `scene` has its meshes and textures already.
renderer::Emitter BuildEmitter(const LightConfig& light,
                               const renderer::Scene& scene,
                               const BuildContext& context);

/// Size and texels of an environment from a latitude-longitude picture; `name` begins messages.
/// Throws IoError, and SceneError for a picture that is not linear.
void ReadEnvironmentFile(const std::filesystem::path& path,
                         const std::string& name,
                         renderer::EnvironmentEmitter& light);

/// The same of a picture whose up is the world's direction `up`.
renderer::EnvironmentEmitter ReadUprightEnvironment(const std::filesystem::path& path,
                                                    const std::string& name,
                                                    const renderer::Vec3& up);

renderer::Camera BuildSensor(const SensorConfig& sensor);

}  // namespace pathfit::app
