#pragma once

#include <string>
#include <vector>

#include "renderer/bsdf/bsdf.h"
#include "renderer/emitter/emitter.h"
#include "renderer/geometry/mesh.h"
#include "renderer/sensor/perspective_camera.h"

namespace pathfit::renderer {

struct Material {
  std::string name;
  Bsdf bsdf;
  Rgb base_color{0.5, 0.5, 0.5};  ///< used unless vertex_colors
  bool vertex_colors = false;     ///< base colour from Mesh::colors, interpolated
  bool two_sided = true;          ///< false: black from behind (it still blocks light)
};

struct SceneMesh {
  std::string name;
  Mesh mesh;  ///< world frame, flat-shaded
  int material = 0;
};

/// Everything that can be rendered: a value that copies, compares and checkpoints.
struct Scene {
  std::vector<SceneMesh> meshes;
  std::vector<Material> materials;
  std::vector<Emitter> emitters;
  std::vector<PerspectiveCamera> sensors;
  /// Whether sensors see the environment behind the objects; coverage counts objects only in either
  /// case.
  bool environment_visible = true;
};

/// Throws SceneError: bad indices, values out of range, vertex colours missing, invalid meshes or
/// cameras, more than one environment.
void ValidateScene(const Scene& scene);

}  // namespace pathfit::renderer
