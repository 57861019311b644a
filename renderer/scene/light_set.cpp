#include "renderer/scene/light_set.h"

namespace pathfit::renderer {

LightSet LightSet::Make(const Scene& scene,
                        const EnvironmentSampler* sampler,
                        const Transform& world_from_camera) {
  LightSet set;
  set.environment_visible = scene.environment_visible;
  for (std::size_t i = 0; i < scene.emitters.size(); ++i) {
    const Emitter& emitter = scene.emitters[i];
    const int index = static_cast<int>(i);
    const Transform world_from_frame =
        emitter.frame == LightFrame::kCamera ? world_from_camera : Transform{};
    if (const auto* environment = std::get_if<EnvironmentEmitter>(&emitter.light)) {
      const Mat3 world_from_light = world_from_frame.linear * environment->frame_from_light;
      set.environment =
          Environment{index, environment, sampler, world_from_light, Transposed(world_from_light)};
    } else if (const auto* point = std::get_if<PointEmitter>(&emitter.light)) {
      set.points.push_back({index, world_from_frame.Point(point->position), point->intensity});
    } else {
      const auto& directional = std::get<DirectionalEmitter>(emitter.light);
      set.directionals.push_back(
          {index, -world_from_frame.Direction(directional.direction), directional.irradiance});
    }
  }
  return set;
}

}  // namespace pathfit::renderer
