#include "renderer/scene/world.h"

#include <algorithm>
#include <utility>

namespace pathfit::renderer {
namespace {

/// Whether a parameter changes where anything is, so that the acceleration structures are stale.
bool MovesMeshes(ParameterKind kind) {
  return kind == ParameterKind::kVertexPositions || kind == ParameterKind::kObjectTranslation ||
         kind == ParameterKind::kObjectRotation || kind == ParameterKind::kObjectScale;
}

}  // namespace

World::World(Scene scene) : scene_(std::move(scene)) {
  ValidateScene(scene_);
  for (const SceneMesh& m : scene_.meshes) {
    topologies_.push_back(MeshTopology::Build(m.mesh));
  }
  PlaceMeshes();
  light_samplers_ = LightSamplers::Make(*this);
}

void World::PlaceMeshes() {
  meshes_ = WorldMeshes(scene_);
  std::vector<const Mesh*> all;
  for (std::size_t m = 0; m < meshes_.size(); ++m) {
    all.push_back(&meshes_[m]);
    topologies_[m].UpdateSolid(meshes_[m]);
  }
  caster_.Build(all);
  edge_trees_.Clear();
}

void World::SetParameters(const ParameterLayout& layout, const std::vector<double>& values) {
  layout.Scatter(values, scene_);
  const auto& groups = layout.groups();
  const auto changes_mesh = [](const ParameterGroup& g) {
    return ObjectListOf(g.kind) == ObjectList::kMeshes;
  };
  if (std::any_of(
          groups.begin(), groups.end(), [](const auto& g) { return MovesMeshes(g.kind); })) {
    PlaceMeshes();
  } else if (std::any_of(groups.begin(), groups.end(), changes_mesh)) {
    meshes_ = WorldMeshes(scene_);
  }
  light_samplers_ = LightSamplers::Make(*this);
}

}  // namespace pathfit::renderer
