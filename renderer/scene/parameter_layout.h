#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "renderer/scene/scene.h"

namespace pathfit::renderer {

/// What may be differentiated. `object` of a group indexes the scene's list named here.
enum class ParameterKind {
  kVertexPositions,       ///< meshes; one block of 3 per position, metres of the object's frame
  kVertexNormals,         ///< meshes with normals; one block of 3 per normal, need not be unit
  kUvs,                   ///< meshes with UVs; one block of 2 per UV
  kVertexColors,          ///< meshes; one block of 3 per colour, linear
  kObjectTranslation,     ///< meshes; one block of 3, metres
  kObjectRotation,        ///< meshes; one block of 3, rotation vector in radians
  kObjectScale,           ///< meshes; one block of 1
  kBaseColor,             ///< materials; one block of 3
  kRoughness,             ///< materials; one block of 1, perceptual
  kMetallic,              ///< materials; one block of 1
  kEta,                   ///< materials; one block of 3 (metals) or 1 (dielectrics)
  kExtinction,            ///< materials, metals; one block of 3: k
  kTextureTexels,         ///< textures; one block of 3 (1 if scalar) per texel
  kLightIntensity,        ///< emitters; one block of 3
  kLightPosition,         ///< point, spot, projector; one block of 3, metres of the light's frame
  kLightRotation,         ///< all but point and area; one block of 3, rotation vector in radians
  kSpotAngles,            ///< spots; one block of 2: inner, outer, radians
  kEnvironmentTexels,     ///< emitters; one block of 3 per texel
  kExposure,              ///< sensors; one block of 1: the gain
  kCameraPosition,        ///< sensors; one block of 3, metres of the world
  kCameraRotation,        ///< sensors; one block of 3: Camera::rotation
  kFocal,                 ///< sensors; one block of 2: fx, fy, pixels
  kPrincipalPoint,        ///< sensors; one block of 2: cx, cy, pixels
  kRadialDistortion,      ///< sensors, perspective; one block of 3: k1, k2, k3
  kTangentialDistortion,  ///< sensors, perspective; one block of 2: p1, p2
};

/// Parameters of one object, e.g. all vertices of a mesh. Blocks are numbered through all groups of
/// a layout.
struct ParameterGroup {
  ParameterKind kind = ParameterKind::kVertexPositions;
  int object = 0;
  std::string name;  ///< e.g. "axe.vertices"
  std::int32_t first_block = 0;
  std::int32_t num_blocks = 0;
  int block_size = 3;             ///< 1, 2 or 3
  std::int64_t first_scalar = 0;  ///< offset of the group in a flat vector of all parameters
};

/// Name of the property in `OBJECT.PROPERTY`, e.g. "vertices".
const char* PropertyName(ParameterKind kind);
/// Which list of the scene a kind's object indexes.
enum class ObjectList { kMeshes, kMaterials, kTextures, kEmitters, kSensors };
ObjectList ObjectListOf(ParameterKind kind);

/// The active parameters of a scene in a fixed order: flat vector of doubles <-> blocks <-> scene
/// values.
class ParameterLayout {
 public:
  ParameterLayout() = default;
  explicit ParameterLayout(const Scene& scene);  ///< sizes of the objects are read from the scene

  /// Appends a group. Throws SceneError if it does not exist in the scene, or twice.
  void Add(ParameterKind kind, int object);

  [[nodiscard]] const std::vector<ParameterGroup>& groups() const { return groups_; }
  [[nodiscard]] std::int32_t NumBlocks() const { return num_blocks_; }
  [[nodiscard]] std::int64_t NumScalars() const { return num_scalars_; }
  /// First block of a group, -1 if it is not active.
  [[nodiscard]] std::int32_t FirstBlock(ParameterKind kind, int object) const;
  [[nodiscard]] const ParameterGroup& GroupOfBlock(std::int32_t block) const;
  [[nodiscard]] std::int64_t FirstScalarOfBlock(std::int32_t block) const;
  /// "axe.vertices[17].y" for messages.
  [[nodiscard]] std::string ScalarName(std::int32_t block, int component) const;

  [[nodiscard]] std::vector<double> Gather(const Scene& scene) const;
  void Scatter(const std::vector<double>& values, Scene& scene) const;

 private:
  /// Shape of a group that the scene could have; num_blocks 0 where the object lacks the property.
  [[nodiscard]] ParameterGroup Describe(ParameterKind kind, int object) const;

  struct Sizes;
  std::shared_ptr<const Sizes> sizes_;
  std::vector<ParameterGroup> groups_;
  std::int32_t num_blocks_ = 0;
  std::int64_t num_scalars_ = 0;
};

}  // namespace pathfit::renderer
