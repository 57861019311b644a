#include "renderer/scene/world.h"

#include <algorithm>
#include <utility>

#include "renderer/core/error.h"

namespace pathfit::renderer {

World::World(Scene scene, const std::optional<RayFrame>& ray_frame) : scene_(std::move(scene)) {
  ValidateScene(scene_);
  for (const SceneMesh& m : scene_.meshes) {
    topologies_.push_back(MeshTopology::Build(m.mesh));
    const Material& material = scene_.materials[static_cast<std::size_t>(m.material)];
    tangents_.push_back(material.normal_texture >= 0 ? TangentField(m.mesh) : TangentField());
  }
  PlaceMeshes(ray_frame);
  light_samplers_.Reset(*this);
}

void World::UpdateTangents() {
  for (std::size_t m = 0; m < meshes_.size(); ++m) {
    if (!tangents_[m].empty()) tangents_[m].Update(meshes_[m]);
  }
}

void World::PlaceMeshes(const std::optional<RayFrame>& ray_frame) {
  meshes_ = WorldMeshes(scene_);
  UpdateTangents();
  std::vector<const Mesh*> all;
  for (std::size_t m = 0; m < meshes_.size(); ++m) {
    all.push_back(&meshes_[m]);
    topologies_[m].UpdateSolid(meshes_[m]);
  }
  // A small lamp far away says nothing about where details are.
  std::vector<bool> lamps(meshes_.size(), false);
  for (const Emitter& emitter : scene_.emitters) {
    if (const auto* area = std::get_if<AreaEmitter>(&emitter.light)) {
      lamps[static_cast<std::size_t>(area->mesh)] = true;
    }
  }
  caster_.Build(all, lamps, ray_frame);
  own_corners_.clear();
  for (int m = 0; m < NumMeshes(); ++m) {
    own_corners_.push_back(std::make_unique<OwnCorners>(caster_.TrianglesOf(m)));
  }
  contacts_.reset();
  edge_trees_.Clear();
}

const EdgeContacts& World::contacts() const {
  const std::lock_guard lock(contacts_mutex_);
  if (!contacts_) {
    contacts_.emplace(caster_, meshes_, topologies_);
  }
  return *contacts_;
}

void World::SetParameters(const ParameterLayout& layout, const std::vector<double>& values) {
  layout.Scatter(values, scene_);
  Rebuild(layout);
}

void World::SetCheckedParameters(const ParameterLayout& layout, const std::vector<double>& values) {
  const std::vector<double> before = layout.Gather(scene_);
  layout.Scatter(values, scene_);
  try {
    ValidateScene(scene_);
  } catch (const SceneError&) {
    layout.Scatter(before, scene_);
    throw;
  }
  Rebuild(layout);
}

void World::Rebuild(const ParameterLayout& layout) {
  const bool meshes_moved = layout.AnyKind(MovesMeshes);
  if (meshes_moved) {
    PlaceMeshes();
  } else if (layout.AnyKind(
                 [](ParameterKind kind) { return TraitsOf(kind).list == ObjectList::kMeshes; })) {
    meshes_ = WorldMeshes(scene_);
    UpdateTangents();
  }
  const auto changes_lights = [](ParameterKind kind) {
    const ObjectList list = TraitsOf(kind).list;
    return list == ObjectList::kEmitters || list == ObjectList::kTextures ||
           kind == ParameterKind::kUvs;
  };
  if (meshes_moved || layout.AnyKind(changes_lights)) {
    light_samplers_.Reset(*this);
  }
}

}  // namespace pathfit::renderer
