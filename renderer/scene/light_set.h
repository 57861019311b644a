#pragma once

#include <optional>
#include <vector>

#include "renderer/emitter/environment_sampler.h"
#include "renderer/scene/scene.h"

namespace pathfit::renderer {

/// Emitters of a scene as one sensor meets them: camera-frame lights are turned into the world.
/// Indices are those of Scene::emitters.
struct LightSet {
  struct Environment {
    int emitter = -1;
    const EnvironmentEmitter* light = nullptr;
    const EnvironmentSampler* sampler = nullptr;
    Mat3 world_from_light, light_from_world;
  };
  struct Point {
    int emitter;
    Vec3 position;
    Rgb intensity;
  };
  struct Directional {
    int emitter;
    Vec3 to_light;  ///< unit
    Rgb irradiance;
  };
  std::optional<Environment> environment;
  std::vector<Point> points;
  std::vector<Directional> directionals;
  bool environment_visible = true;

  /// `sampler` belongs to the scene's environment (null if there is none) and must outlive the
  /// result, as the scene.
  static LightSet Make(const Scene& scene,
                       const EnvironmentSampler* sampler,
                       const Transform& world_from_camera);
};

}  // namespace pathfit::renderer
