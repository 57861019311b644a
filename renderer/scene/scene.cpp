#include "renderer/scene/scene.h"

#include <algorithm>

#include "renderer/core/error.h"

namespace pathfit::renderer {
namespace {

void Require(bool condition, const std::string& where, const std::string& what) {
  if (!condition) {
    throw SceneError(where + ": " + what);
  }
}

bool InRange(const Rgb& c, double low, double high) {
  return IsFinite(c) && std::min({c.r, c.g, c.b}) >= low && MaxChannel(c) <= high;
}

void ValidateMaterial(const Material& material) {
  const std::string where = "material '" + material.name + "'";
  Require(
      InRange(material.base_color, 0.0, 1e6), where, "base_color must be finite and not negative");
  if (const auto* m = std::get_if<MetallicRoughnessBsdf>(&material.bsdf)) {
    Require(m->roughness >= kMinRoughness && m->roughness <= 1.0,
            where,
            "roughness must lie in [0.1, 1]");
    Require(m->metallic >= 0.0 && m->metallic <= 1.0, where, "metallic must lie in [0, 1]");
  }
}

void ValidateEmitter(const Emitter& emitter) {
  const std::string where = "light '" + emitter.name + "'";
  Require(InRange(LightIntensity(emitter), 0.0, 1e30),
          where,
          "intensity must be finite and not negative");
  if (const auto* environment = std::get_if<EnvironmentEmitter>(&emitter.light)) {
    const auto size = static_cast<std::size_t>(environment->width) *
                      static_cast<std::size_t>(environment->height);
    Require(environment->width > 0 && environment->height > 0 && environment->texels.size() == size,
            where,
            "texels do not match width and height");
    Require(std::all_of(environment->texels.begin(),
                        environment->texels.end(),
                        [](const Rgb& t) { return InRange(t, 0.0, 1e30); }),
            where,
            "texels must be finite and not negative");
  } else if (const auto* point = std::get_if<PointEmitter>(&emitter.light)) {
    Require(IsFinite(point->position), where, "position must be finite");
  } else {
    const auto& directional = std::get<DirectionalEmitter>(emitter.light);
    Require(std::abs(Norm(directional.direction) - 1.0) < 1e-9,
            where,
            "direction must be a unit vector");
  }
}

}  // namespace

void ValidateScene(const Scene& scene) {
  for (const SceneMesh& m : scene.meshes) {
    const std::string where = "mesh '" + m.name + "'";
    ValidateMesh(m.mesh, m.name);
    Require(m.material >= 0 && static_cast<std::size_t>(m.material) < scene.materials.size(),
            where,
            "its material does not exist");
    const bool needs_colors = scene.materials[static_cast<std::size_t>(m.material)].vertex_colors;
    Require(!needs_colors || m.mesh.HasColors(),
            where,
            "its material takes vertex colours, the mesh has none");
    Require(!m.mesh.HasColors() || m.mesh.color_triangles.size() == m.mesh.triangles.size(),
            where,
            "colour indices do not match its triangles");
    Require(std::all_of(m.mesh.colors.begin(),
                        m.mesh.colors.end(),
                        [](const Rgb& c) { return InRange(c, 0.0, 1e6); }),
            where,
            "colours must be finite and not negative");
  }
  std::for_each(scene.materials.begin(), scene.materials.end(), ValidateMaterial);
  std::for_each(scene.emitters.begin(), scene.emitters.end(), ValidateEmitter);
  const auto environments =
      std::count_if(scene.emitters.begin(), scene.emitters.end(), [](const Emitter& e) {
        return std::holds_alternative<EnvironmentEmitter>(e.light);
      });
  Require(environments <= 1, "lights", "at most one environment is possible");
  for (const PerspectiveCamera& camera : scene.sensors) {
    const CameraModel model(camera);  // validates
  }
}

}  // namespace pathfit::renderer
