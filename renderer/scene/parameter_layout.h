#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/scene/scene.h"

namespace pathfit::renderer {

/// What may be differentiated. `object` of a group indexes the scene's list named here.
enum class ParameterKind {
  kVertexPositions,    ///< meshes; one block of 3 per position, metres
  kVertexColors,       ///< meshes; one block of 3 per colour, linear
  kBaseColor,          ///< materials; one block of 3
  kRoughness,          ///< materials; one block of 1, perceptual
  kMetallic,           ///< materials; one block of 1
  kLightIntensity,     ///< emitters; one block of 3
  kEnvironmentTexels,  ///< emitters; one block of 3 per texel
  kExposure,           ///< sensors; one block of 1: the gain
};

/// Parameters of one object, e.g. all vertices of a mesh. Blocks are numbered through all groups of
/// a layout.
struct ParameterGroup {
  ParameterKind kind = ParameterKind::kVertexPositions;
  int object = 0;
  std::string name;  ///< e.g. "axe.vertices"
  std::int32_t first_block = 0;
  std::int32_t num_blocks = 0;
  int block_size = 3;             ///< 1 or 3
  std::int64_t first_scalar = 0;  ///< offset of the group in a flat vector of all parameters
};

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
  struct Sizes {
    std::vector<std::int32_t> positions, colors, texels;
    std::vector<bool> rough;  // materials with roughness and metallic
    std::vector<std::string> meshes, materials, emitters, sensors;
  };
  Sizes sizes_;
  std::vector<ParameterGroup> groups_;
  std::int32_t num_blocks_ = 0;
  std::int64_t num_scalars_ = 0;
};

}  // namespace pathfit::renderer
