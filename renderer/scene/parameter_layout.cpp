#include "renderer/scene/parameter_layout.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/scene/parameter_values.h"

namespace pathfit::renderer {
namespace {

struct KindInfo {
  ParameterKind kind;
  const char* property;
  ObjectList list;
  int block_size;          // of most objects; kEta and kTextureTexels may have 1
  const char* components;  // letters of a block's components
};

constexpr KindInfo kKinds[] = {
    {ParameterKind::kVertexPositions, "vertices", ObjectList::kMeshes, 3, "xyz"},
    {ParameterKind::kVertexNormals, "normals", ObjectList::kMeshes, 3, "xyz"},
    {ParameterKind::kUvs, "uvs", ObjectList::kMeshes, 2, "uv"},
    {ParameterKind::kVertexColors, "colors", ObjectList::kMeshes, 3, "rgb"},
    {ParameterKind::kObjectTranslation, "translation", ObjectList::kMeshes, 3, "xyz"},
    {ParameterKind::kObjectRotation, "rotation", ObjectList::kMeshes, 3, "xyz"},
    {ParameterKind::kObjectScale, "scale", ObjectList::kMeshes, 1, ""},
    {ParameterKind::kBaseColor, "base_color", ObjectList::kMaterials, 3, "rgb"},
    {ParameterKind::kRoughness, "roughness", ObjectList::kMaterials, 1, ""},
    {ParameterKind::kMetallic, "metallic", ObjectList::kMaterials, 1, ""},
    {ParameterKind::kEta, "eta", ObjectList::kMaterials, 3, "rgb"},
    {ParameterKind::kExtinction, "k", ObjectList::kMaterials, 3, "rgb"},
    {ParameterKind::kTextureTexels, "texels", ObjectList::kTextures, 3, "rgb"},
    {ParameterKind::kLightIntensity, "intensity", ObjectList::kEmitters, 3, "rgb"},
    {ParameterKind::kLightPosition, "position", ObjectList::kEmitters, 3, "xyz"},
    {ParameterKind::kLightRotation, "rotation", ObjectList::kEmitters, 3, "xyz"},
    {ParameterKind::kSpotAngles, "angles", ObjectList::kEmitters, 2, "io"},
    {ParameterKind::kEnvironmentTexels, "texels", ObjectList::kEmitters, 3, "rgb"},
    {ParameterKind::kExposure, "exposure", ObjectList::kSensors, 1, ""},
    {ParameterKind::kCameraPosition, "position", ObjectList::kSensors, 3, "xyz"},
    {ParameterKind::kCameraRotation, "rotation", ObjectList::kSensors, 3, "xyz"},
    {ParameterKind::kFocal, "focal", ObjectList::kSensors, 2, "xy"},
    {ParameterKind::kPrincipalPoint, "principal_point", ObjectList::kSensors, 2, "xy"},
    {ParameterKind::kRadialDistortion, "distortion", ObjectList::kSensors, 3, "123"},
    {ParameterKind::kTangentialDistortion, "tangential", ObjectList::kSensors, 2, "12"},
};

const KindInfo& InfoOf(ParameterKind kind) {
  const auto* found = std::find_if(
      std::begin(kKinds), std::end(kKinds), [&](const auto& k) { return k.kind == kind; });
  PATHFIT_CHECK(found != std::end(kKinds));
  return *found;
}

}  // namespace

const char* PropertyName(ParameterKind kind) { return InfoOf(kind).property; }
ObjectList ObjectListOf(ParameterKind kind) { return InfoOf(kind).list; }

/// Number of scalars of every property that exists, and the objects' names.
struct ParameterLayout::Sizes {
  struct Object {
    std::string name;
    std::vector<std::pair<ParameterKind, std::int32_t>> scalars;
    bool scalar_texture = false;
  };
  std::array<std::vector<Object>, 5> lists;
};

ParameterLayout::ParameterLayout(const Scene& scene) {
  auto sizes = std::make_shared<Sizes>();
  const auto add = [&](const auto& list, ObjectList which) {
    auto& objects = sizes->lists[static_cast<std::size_t>(which)];
    for (std::size_t i = 0; i < list.size(); ++i) {
      objects.push_back({list[i].name, {}, false});
      for (const KindInfo& info : kKinds) {
        if (info.list == which) {
          // Only counted; the pointers are not kept.
          auto& mutable_scene = const_cast<Scene&>(scene);  // NOLINT: nothing is written
          const auto count = ParameterScalars(mutable_scene, info.kind, static_cast<int>(i)).size();
          objects.back().scalars.emplace_back(info.kind, static_cast<std::int32_t>(count));
        }
      }
    }
  };
  add(scene.meshes, ObjectList::kMeshes);
  add(scene.materials, ObjectList::kMaterials);
  add(scene.textures, ObjectList::kTextures);
  add(scene.emitters, ObjectList::kEmitters);
  add(scene.sensors, ObjectList::kSensors);
  for (std::size_t i = 0; i < scene.textures.size(); ++i) {
    sizes->lists[static_cast<std::size_t>(ObjectList::kTextures)][i].scalar_texture =
        scene.textures[i].scalar;
  }
  sizes_ = std::move(sizes);
}

ParameterGroup ParameterLayout::Describe(ParameterKind kind, int object) const {
  const KindInfo& info = InfoOf(kind);
  if (sizes_ == nullptr || object < 0 ||
      static_cast<std::size_t>(object) >=
          sizes_->lists[static_cast<std::size_t>(info.list)].size()) {
    throw SceneError(std::string("no object ") + std::to_string(object) + " with parameter '" +
                     info.property + "'");
  }
  const Sizes::Object& item =
      sizes_->lists[static_cast<std::size_t>(info.list)][static_cast<std::size_t>(object)];
  const auto count = std::find_if(item.scalars.begin(), item.scalars.end(), [&](const auto& s) {
                       return s.first == kind;
                     })->second;
  ParameterGroup group;
  group.kind = kind;
  group.object = object;
  group.name = item.name + "." + info.property;
  const bool one = item.scalar_texture || (kind == ParameterKind::kEta && count == 1);
  group.block_size = one ? 1 : info.block_size;
  group.num_blocks = count / group.block_size;
  return group;
}

void ParameterLayout::Add(ParameterKind kind, int object) {
  ParameterGroup group = Describe(kind, object);
  if (group.num_blocks == 0) {
    throw SceneError("'" + group.name + "' does not exist in this scene");
  }
  if (FirstBlock(kind, object) >= 0) {
    throw SceneError("'" + group.name + "' is listed twice");
  }
  group.first_block = num_blocks_;
  group.first_scalar = num_scalars_;
  num_blocks_ += group.num_blocks;
  num_scalars_ += static_cast<std::int64_t>(group.num_blocks) * group.block_size;
  groups_.push_back(group);
}

std::int32_t ParameterLayout::FirstBlock(ParameterKind kind, int object) const {
  const auto found = std::find_if(groups_.begin(), groups_.end(), [&](const auto& g) {
    return g.kind == kind && g.object == object;
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
    name += std::string(".") + InfoOf(group.kind).components[component];
  }
  return name;
}

std::vector<double> ParameterLayout::Gather(const Scene& scene) const {
  auto& mutable_scene = const_cast<Scene&>(scene);  // NOLINT: nothing is written
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(num_scalars_));
  for (const ParameterGroup& group : groups_) {
    for (const double* x : ParameterScalars(mutable_scene, group.kind, group.object)) {
      values.push_back(*x);
    }
  }
  PATHFIT_CHECK(values.size() == static_cast<std::size_t>(num_scalars_));
  return values;
}

void ParameterLayout::Scatter(const std::vector<double>& values, Scene& scene) const {
  PATHFIT_CHECK(values.size() == static_cast<std::size_t>(num_scalars_));
  std::size_t next = 0;
  for (const ParameterGroup& group : groups_) {
    for (double* x : ParameterScalars(scene, group.kind, group.object)) {
      *x = values[next++];
    }
    if (group.kind == ParameterKind::kTextureTexels && group.block_size == 1) {
      for (Rgb& t : scene.textures[static_cast<std::size_t>(group.object)].texels) {
        t = Rgb::Constant(t.r);
      }
    }
  }
}

}  // namespace pathfit::renderer
