#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "renderer/geometry/edge_contact.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/geometry/own_corners.h"
#include "renderer/geometry/ray_caster.h"
#include "renderer/geometry/tangents.h"
#include "renderer/scene/light_set.h"
#include "renderer/scene/parameter_layout.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/scene_edges.h"

namespace pathfit::renderer {

/// A scene made ready for rays, and the only owner of what is derived from it: its meshes in the
/// world frame, their topology, the acceleration structures over triangles and edges, and the
/// samplers of its lights. Everything it returns refers to the present state: it is invalid after
/// SetParameters. Constant members may be called from several threads at once.
class World {
 public:
  /// Throws SceneError if the scene is not valid. `ray_frame`: see RayCaster::Build.
  explicit World(Scene scene, const std::optional<RayFrame>& ray_frame = {});
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// The scene as given: its meshes are in their objects' frames.
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] int NumMeshes() const { return static_cast<int>(meshes_.size()); }
  /// A mesh of the scene in the world frame, metres.
  [[nodiscard]] const Mesh& mesh(int index) const {
    return meshes_[static_cast<std::size_t>(index)];
  }
  [[nodiscard]] const Material& MaterialOf(int mesh) const {
    return scene_.materials[static_cast<std::size_t>(
        scene_.meshes[static_cast<std::size_t>(mesh)].material)];
  }
  /// Of a mesh whose material has a normal texture, in the world; else empty.
  [[nodiscard]] const TangentField& tangents(int mesh) const {
    return tangents_[static_cast<std::size_t>(mesh)];
  }
  [[nodiscard]] const MeshTopology& topology(int mesh) const {
    return topologies_[static_cast<std::size_t>(mesh)];
  }
  [[nodiscard]] const RayCaster& caster() const { return caster_; }
  /// Of a mesh in the world: all views of a round share what it finds.
  [[nodiscard]] const OwnCorners& own_corners(int mesh) const {
    return *own_corners_[static_cast<std::size_t>(mesh)];
  }
  /// Found when they are asked for first.
  [[nodiscard]] const EdgeContacts& contacts() const;
  [[nodiscard]] const LightSamplers& light_samplers() const { return light_samplers_; }
  /// The edges that can hide one thing from another as seen from `viewer`, where the meshes with
  /// moves[mesh] move; see SceneEdges. Kept while neither state nor selection change: most views of
  /// a round share one tree.
  [[nodiscard]] std::shared_ptr<const EdgeTree> EdgesFor(const std::vector<bool>& moves,
                                                         const Vec3& viewer) const {
    return edge_trees_.Get(*this, SelectEdges(*this, moves, viewer));
  }

  /// Writes parameter values, in the layout's order and units, into the scene and rebuilds what
  /// depends on them.
  void SetParameters(const ParameterLayout& layout, const std::vector<double>& values);
  /// The same of any values: throws SceneError, and changes nothing, if the scene would not be
  /// valid.
  void SetCheckedParameters(const ParameterLayout& layout, const std::vector<double>& values);

 private:
  /// What depends on the parameters of the layout.
  void Rebuild(const ParameterLayout& layout);
  void UpdateTangents();
  void PlaceMeshes(const std::optional<RayFrame>& ray_frame = {});

  Scene scene_;
  std::vector<Mesh> meshes_;
  std::vector<MeshTopology> topologies_;
  std::vector<TangentField> tangents_;
  RayCaster caster_;
  std::vector<std::unique_ptr<OwnCorners>> own_corners_;
  LightSamplers light_samplers_;
  mutable std::mutex contacts_mutex_;
  mutable std::optional<EdgeContacts> contacts_;
  mutable EdgeTreeCache edge_trees_;
};

}  // namespace pathfit::renderer
