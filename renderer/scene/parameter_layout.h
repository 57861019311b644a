#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "renderer/scene/parameter_kinds.h"
#include "renderer/scene/scene.h"

namespace pathfit::renderer {

/// Parameters of one kind of one object, e.g. all vertices of a mesh. A block is what belongs
/// together: a vertex, a texel, a translation.
struct ParameterGroup {
  ParameterKind kind = ParameterKind::kVertexPositions;
  int object = 0;                 ///< into the kind's list of the scene
  std::vector<int> sharing;       ///< further objects that have the same numbers
  std::string name;               ///< "axe.vertices"
  const char* components = "";    ///< a letter each; empty: one number
  std::int32_t first_block = 0;   ///< blocks are numbered through all groups of a layout
  std::int32_t num_blocks = 0;    ///< > 0
  int block_size = 3;             ///< numbers per block: 1, 2 or 3
  std::int64_t first_scalar = 0;  ///< offset of the group in a flat vector of all parameters

  [[nodiscard]] std::size_t NumScalars() const {
    return static_cast<std::size_t>(num_blocks) * static_cast<std::size_t>(block_size);
  }
};

/// Which parameters of a scene are active, in a fixed order, and where their values stand in a flat
/// vector: group after group as added, block after block, component after component. Component c of
/// block b of group g is number
///
///   g.first_scalar + (b - g.first_block) * g.block_size + c,  g.first_block <= b.
///
/// Values have the units of their kinds (ParameterTraits::unit) and are not scaled, bounded or
/// logarithms. The scene's own values are read and written in place; a layout holds none, and no
/// reference to the scene that it was made from.
///
/// A layout fits every scene that has the same objects with lists of the same lengths as the one
/// that it was made from. With another one, Gather and Scatter throw InternalError or, where lists
/// of objects are shorter, must not be called.
class ParameterLayout {
 public:
  /// Of no scene: nothing can be added.
  ParameterLayout() = default;
  /// Without groups. Takes time in proportion to the number of objects, not of their texels or
  /// vertices.
  explicit ParameterLayout(const Scene& scene);

  /// Appends a group; object -1 stands for every sensor, each a group of its own. `sharing`:
  /// further objects whose numbers are the same ones, such as pictures by one lens; what the scene
  /// says of `object` counts for all. Throws SceneError if the scene has no such object, if one
  /// lacks the property or has it in another size, or if it is in the layout already.
  void Add(ParameterKind kind, int object, std::vector<int> sharing = {});

  [[nodiscard]] const std::vector<ParameterGroup>& groups() const { return groups_; }
  [[nodiscard]] std::int32_t NumBlocks() const { return num_blocks_; }
  [[nodiscard]] std::int64_t NumScalars() const { return num_scalars_; }
  /// Whether a group is of such a kind.
  [[nodiscard]] bool AnyKind(bool (*is)(ParameterKind)) const;
  /// First block of a kind of an object, be it shared, -1 if it is not active.
  [[nodiscard]] std::int32_t FirstBlock(ParameterKind kind, int object) const;
  /// The group that a block belongs to; `block` must be in [0, NumBlocks()).
  [[nodiscard]] const ParameterGroup& GroupOfBlock(std::int32_t block) const;
  /// Place of a block's first component in the flat vector; `block` must be in [0, NumBlocks()).
  [[nodiscard]] std::int64_t FirstScalarOfBlock(std::int32_t block) const;
  /// "axe.vertices[17].y" for messages; without index in groups of one block, without letter in
  /// blocks of one number.
  [[nodiscard]] std::string ScalarName(std::int32_t block, int component) const;

  /// NumScalars() values of the scene, which must fit.
  [[nodiscard]] std::vector<double> Gather(const Scene& scene) const;
  /// The same in the memory of `values`, whatever they were: for many texels, memory that was never
  /// touched costs more than copying does.
  void Gather(const Scene& scene, std::vector<double>& values) const;
  /// Writes NumScalars() values into the scene, which must fit; they are not checked. Lists that
  /// are shared with other scenes become its own, all others stay shared.
  void Scatter(const std::vector<double>& values, Scene& scene) const;

 private:
  struct Objects;
  /// What the scene could have, and has not in the layout yet.
  [[nodiscard]] const ParameterGroup& PossibleGroup(ParameterKind kind, int object) const;

  std::shared_ptr<const Objects> objects_;
  std::vector<ParameterGroup> groups_;
  std::int32_t num_blocks_ = 0;
  std::int64_t num_scalars_ = 0;
};

}  // namespace pathfit::renderer
