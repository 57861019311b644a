#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "renderer/bsdf/bsdf.h"
#include "renderer/emitter/emitter.h"
#include "renderer/geometry/mesh.h"
#include "renderer/sensor/camera.h"
#include "renderer/texture/texture.h"

namespace pathfit::renderer {

struct Material {
  std::string name;
  Bsdf bsdf;
  Rgb base_color{0.5, 0.5, 0.5};  ///< used unless vertex_colors or a texture
  bool vertex_colors = false;     ///< base colour from Mesh::colors, interpolated
  int base_color_texture = -1;    ///< into Scene::textures, -1: none
  int roughness_texture = -1;     ///< scalar; replaces the model's constant
  int metallic_texture = -1;      ///< scalar; replaces the model's constant
  /// Directions in the mesh's tangent frames (tangents.h) as (1 + n) / 2: turns the interpolated
  /// normals, which the mesh must have.
  int normal_texture = -1;
  double normal_scale = 1.0;  ///< of the directions' x and y
  bool two_sided = true;      ///< false: black from behind (it still blocks light); no meaning for
                              ///< transmissive models

  /// All of them, -1 where there is none.
  [[nodiscard]] std::array<int, 4> Textures() const {
    return {base_color_texture, roughness_texture, metallic_texture, normal_texture};
  }
  [[nodiscard]] bool IsTextured() const {
    return base_color_texture >= 0 || roughness_texture >= 0 || metallic_texture >= 0 ||
           normal_texture >= 0;
  }
};

/// Where an object is: x_world = pivot + translation + scale * R (x - pivot), with R the rotation
/// of the rotation vector. Normals turn with R.
struct ObjectPose {
  Vec3 pivot{0.0, 0.0, 0.0};        ///< fixed, usually the middle of the object
  Vec3 translation{0.0, 0.0, 0.0};  ///< metres
  Vec3 rotation{0.0, 0.0, 0.0};     ///< axis times radians, right-handed
  double scale = 1.0;               ///< > 0
  friend bool operator==(const ObjectPose&, const ObjectPose&) = default;
};

struct SceneMesh {
  std::string name;
  Mesh mesh;  ///< object frame, the world's if the pose is the identity; smooth if it has normals
  int material = 0;
  ObjectPose pose = {};
};

/// Everything that can be rendered: a value that copies, compares and checkpoints.
struct Scene {
  std::vector<SceneMesh> meshes;
  std::vector<Material> materials;
  std::vector<Texture> textures;
  std::vector<Emitter> emitters;
  std::vector<Camera> sensors;
  /// Whether sensors see the environment behind the objects; coverage counts objects only in either
  /// case.
  bool environment_visible = true;
};

/// Whether there is an environment that sensors see, unless it is off in their photos
/// (Camera::lights_off).
bool ShowsEnvironment(const Scene& scene);

/// The light that a mesh is; null: none.
const AreaEmitter* AreaLightOf(const Scene& scene, std::size_t mesh);

/// The mesh in the world frame.
Mesh WorldMesh(const SceneMesh& mesh);
/// All meshes of a scene in the world frame, in its order.
std::vector<Mesh> WorldMeshes(const Scene& scene);

/// Throws SceneError: bad indices, values out of range, vertex colours or UVs missing, invalid
/// meshes or cameras, more than one environment, a mesh with two area lights.
void ValidateScene(const Scene& scene);

}  // namespace pathfit::renderer
