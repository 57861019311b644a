#include "renderer/scene/parameter_layout.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "renderer/core/check.h"
#include "renderer/core/error.h"

namespace pathfit::renderer {
namespace {

bool Fits(const ParameterGroup& group, std::int32_t num_blocks, int block_size) {
  return group.num_blocks == num_blocks && group.block_size == block_size;
}

/// To one of the objects that have the group's numbers.
void WriteGroup(const ParameterGroup& group, int object, const double* next, Scene& scene) {
  const auto blocks = TraitsOf(group.kind, scene, object).edit(scene, object);
  PATHFIT_CHECK(Fits(group, blocks.num_blocks, blocks.block_size));
  if (blocks.stride == static_cast<std::size_t>(blocks.block_size)) {
    std::copy_n(next, static_cast<std::size_t>(blocks.num_blocks) * blocks.stride, blocks.first);
    return;
  }
  // The scalar texels: their three channels are one number.
  for (std::int32_t b = 0; b < blocks.num_blocks; ++b) {
    double* item = blocks[b].data();
    std::fill(item, item + blocks.stride, *next++);
  }
}

}  // namespace

/// By list and object: all groups that the scene could have, without their places.
struct ParameterLayout::Objects {
  std::array<std::vector<std::vector<ParameterGroup>>,
             static_cast<std::size_t>(ObjectList::kSensors) + 1>
      lists;
};

ParameterLayout::ParameterLayout(const Scene& scene) {
  auto objects = std::make_shared<Objects>();
  for (const ObjectList list : {ObjectList::kMeshes,
                                ObjectList::kMaterials,
                                ObjectList::kTextures,
                                ObjectList::kEmitters,
                                ObjectList::kSensors}) {
    const std::vector<std::string> names = ObjectNames(scene, list);
    auto& groups_of = objects->lists[static_cast<std::size_t>(list)];
    groups_of.resize(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
      const int object = static_cast<int>(i);
      for (const ParameterTraits& row : AllParameterTraits()) {
        if (row.list != list || !row.is_for(scene, object)) {
          continue;
        }
        const auto blocks = row.read(scene, object);
        groups_of[i].push_back({row.kind,
                                object,
                                {},
                                names[i] + "." + row.property,
                                row.components,
                                0,
                                blocks.num_blocks,
                                blocks.block_size,
                                0});
      }
    }
  }
  objects_ = std::move(objects);
}

const ParameterGroup& ParameterLayout::PossibleGroup(ParameterKind kind, int object) const {
  const ParameterTraits& traits = TraitsOf(kind);
  const auto* list =
      objects_ == nullptr ? nullptr : &objects_->lists[static_cast<std::size_t>(traits.list)];
  if (list == nullptr || object < 0 || static_cast<std::size_t>(object) >= list->size()) {
    throw SceneError(std::string("no object ") + std::to_string(object) + " with parameter '" +
                     traits.property + "'");
  }
  const auto& possible = (*list)[static_cast<std::size_t>(object)];
  const ParameterGroup& group = *std::find_if(
      possible.begin(), possible.end(), [&](const auto& g) { return g.kind == kind; });
  if (group.num_blocks == 0) {
    throw SceneError("'" + group.name + "' does not exist in this scene");
  }
  if (FirstBlock(kind, object) >= 0) {
    throw SceneError("'" + group.name + "' is listed twice");
  }
  return group;
}

void ParameterLayout::Add(ParameterKind kind, int object, std::vector<int> sharing) {
  const ObjectList list = TraitsOf(kind).list;
  const std::size_t num_objects =
      objects_ == nullptr ? 0 : objects_->lists[static_cast<std::size_t>(list)].size();
  if (object == -1 && list == ObjectList::kSensors && num_objects > 0) {
    for (std::size_t i = 0; i < num_objects; ++i) {
      Add(kind, static_cast<int>(i));
    }
    return;
  }
  ParameterGroup group = PossibleGroup(kind, object);
  for (const int other : sharing) {
    const ParameterGroup& shared = PossibleGroup(kind, other);
    if (!Fits(group, shared.num_blocks, shared.block_size)) {
      throw SceneError("'" + shared.name + "' is not of the size of '" + group.name + "'");
    }
  }
  if (list == ObjectList::kSensors && num_objects > 1 && sharing.size() + 1 == num_objects) {
    group.name = std::string(kAllSensors) + "." + TraitsOf(kind).property;
  }
  group.sharing = std::move(sharing);
  group.first_block = num_blocks_;
  group.first_scalar = num_scalars_;
  num_blocks_ += group.num_blocks;
  num_scalars_ += static_cast<std::int64_t>(group.NumScalars());
  groups_.push_back(std::move(group));
}

bool ParameterLayout::AnyKind(bool (*is)(ParameterKind)) const {
  return std::any_of(groups_.begin(), groups_.end(), [is](const auto& g) { return is(g.kind); });
}

std::int32_t ParameterLayout::FirstBlock(ParameterKind kind, int object) const {
  const auto found = std::find_if(groups_.begin(), groups_.end(), [&](const auto& g) {
    return g.kind == kind &&
           (g.object == object || std::ranges::find(g.sharing, object) != g.sharing.end());
  });
  return found == groups_.end() ? -1 : found->first_block;
}

const ParameterGroup& ParameterLayout::GroupOfBlock(std::int32_t block) const {
  PATHFIT_CHECK(block >= 0 && block < num_blocks_);
  const auto above =
      std::upper_bound(groups_.begin(), groups_.end(), block, [](std::int32_t b, const auto& g) {
        return b < g.first_block;
      });
  return *std::prev(above);
}

std::int64_t ParameterLayout::FirstScalarOfBlock(std::int32_t block) const {
  const ParameterGroup& group = GroupOfBlock(block);
  return group.first_scalar +
         static_cast<std::int64_t>(block - group.first_block) * group.block_size;
}

std::string ParameterLayout::ScalarName(std::int32_t block, int component) const {
  const ParameterGroup& group = GroupOfBlock(block);
  std::string name = group.name;
  if (group.num_blocks > 1) {
    name += "[" + std::to_string(block - group.first_block) + "]";
  }
  if (group.block_size > 1) {
    name += std::string(".") + group.components[component];
  }
  return name;
}

std::vector<double> ParameterLayout::Gather(const Scene& scene) const {
  std::vector<double> values;
  Gather(scene, values);
  return values;
}

void ParameterLayout::Gather(const Scene& scene, std::vector<double>& values) const {
  values.clear();
  values.reserve(static_cast<std::size_t>(num_scalars_));
  for (const ParameterGroup& group : groups_) {
    const auto blocks = TraitsOf(group.kind, scene, group.object).read(scene, group.object);
    PATHFIT_CHECK(Fits(group, blocks.num_blocks, blocks.block_size));
    if (blocks.stride == static_cast<std::size_t>(blocks.block_size)) {
      values.insert(values.end(),
                    blocks.first,
                    blocks.first + static_cast<std::size_t>(blocks.num_blocks) * blocks.stride);
      continue;
    }
    const auto size = static_cast<std::size_t>(blocks.block_size);
    std::size_t to = values.size();
    values.resize(to + static_cast<std::size_t>(blocks.num_blocks) * size);
    for (std::int32_t b = 0; b < blocks.num_blocks; ++b, to += size) {
      std::copy_n(blocks[b].data(), size, &values[to]);
    }
  }
}

void ParameterLayout::Scatter(const std::vector<double>& values, Scene& scene) const {
  PATHFIT_CHECK(values.size() == static_cast<std::size_t>(num_scalars_));
  for (const ParameterGroup& group : groups_) {
    WriteGroup(group, group.object, values.data() + group.first_scalar, scene);
    for (const int other : group.sharing) {
      WriteGroup(group, other, values.data() + group.first_scalar, scene);
    }
  }
}

}  // namespace pathfit::renderer
