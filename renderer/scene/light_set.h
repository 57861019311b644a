#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "renderer/emitter/area_sampler.h"
#include "renderer/emitter/environment_sampler.h"
#include "renderer/geometry/ray.h"
#include "renderer/math/box.h"
#include "renderer/scene/scene.h"

namespace pathfit::renderer {

class World;

/// Samplers of a world's lights that do not depend on where the sensor is. Those of area lights are
/// made when a set of them is asked for first: sensors with the same lamps share one. Constant
/// members may be called from several threads at once.
class LightSamplers {
 public:
  /// Forgets what was made of an earlier state.
  void Reset(const World& world);

  /// Of the environment, empty without one.
  [[nodiscard]] const std::optional<EnvironmentSampler>& environment() const {
    return environment_;
  }
  /// Over the triangles of these area lights, indices into Scene::emitters in ascending order.
  /// Refers to this object until Reset.
  [[nodiscard]] const AreaSampler& AreasOf(const World& world,
                                           const std::vector<int>& emitters) const;

 private:
  std::optional<EnvironmentSampler> environment_;
  mutable std::mutex mutex_;
  mutable std::map<std::vector<int>, AreaSampler> areas_;
};

/// Emitters of a world as one sensor meets them: those that are off for it are left out,
/// camera-frame lights are turned into the world, rotations are applied. Indices `emitter` are
/// those of Scene::emitters.
struct LightSet {
  struct Environment {
    int emitter = -1;
    const EnvironmentEmitter* light = nullptr;
    const EnvironmentSampler* sampler = nullptr;
    Mat3 world_from_light, light_from_world;
  };
  /// Point, spot or projector.
  struct PointLight {
    int emitter = -1;
    Vec3 position;  ///< world
    Mat3 world_from_light, light_from_world;
    const Emitter* light = nullptr;
    const Texture* texture = nullptr;  ///< of a projector
  };
  struct Directional {
    int emitter = -1;
    Vec3 to_light;  ///< unit, world
    Rgb irradiance;
  };
  struct AreaLight {
    int emitter = -1;
    const AreaEmitter* light = nullptr;
    const Texture* texture = nullptr;
    const Mesh* mesh = nullptr;
  };
  std::optional<Environment> environment;
  std::vector<PointLight> points;
  std::vector<Directional> directionals;
  std::vector<AreaLight> areas;
  std::vector<int> area_of_mesh;  ///< index into `areas` by mesh, -1 where it does not shine
  const AreaSampler* area_sampler = nullptr;  ///< null without area lights
  /// Around the area lights, for MayMeetArea: one each, or one of all.
  std::vector<Box> area_boxes;
  bool environment_visible = true;
  /// Whether the sensor sees the environment behind the objects.
  [[nodiscard]] bool ShowsEnvironment() const { return environment && environment_visible; }

  /// `lights_off`: Camera::lights_off. All pointers refer to the world, which must outlive the
  /// result.
  static LightSet Make(const World& world,
                       const Transform& world_from_camera,
                       const std::vector<int>& lights_off = {});

  /// False only if rays miss all area lights, as the ray caster finds them. `offset`:
  /// RayCaster::Offset of the origin.
  [[nodiscard]] bool MayMeetArea(const Ray& ray, double offset) const {
    return std::any_of(area_boxes.begin(), area_boxes.end(), [&](const Box& box) {
      return box.MayMeet(ray.origin, ray.direction, offset);
    });
  }

  /// The area light of a mesh, null if it does not shine.
  [[nodiscard]] const AreaLight* AreaLightOf(int mesh) const {
    const int i = area_of_mesh[static_cast<std::size_t>(mesh)];
    return i < 0 ? nullptr : &areas[static_cast<std::size_t>(i)];
  }
};

/// Radiance leaving a point of an area light on side `side` (+1: that of the winding's normal).
Rgb AreaRadiance(
    const LightSet::AreaLight& light, std::int32_t triangle, double b1, double b2, double side);
/// The factor of that radiance which intensity multiplies, and the texture lookup behind it
/// (weights zero without texture).
struct AreaRadiancePartials {
  Rgb value;   ///< AreaRadiance
  Rgb factor;  ///< value per intensity
  TextureLookup lookup;
};
AreaRadiancePartials AreaRadianceDerivative(
    const LightSet::AreaLight& light, std::int32_t triangle, double b1, double b2, double side);

/// Radiant intensity (W/sr) of a point, spot or projector in unit world direction w from it.
Rgb IntensityTowards(const LightSet::PointLight& light, const Vec3& w);
/// The same with its derivatives.
struct IntensityPartials {
  Rgb value;
  Rgb factor;                 ///< value per intensity
  std::array<Vec3, 3> d_w{};  ///< of each channel by the world direction w (tangential)
  Rgb d_inner, d_outer;       ///< by the spot's angles
  TextureLookup lookup;       ///< of a projector; value = intensity * scale * lookup.value
  double texture_scale = 0.0;
};
IntensityPartials IntensityDerivative(const LightSet::PointLight& light, const Vec3& w);

}  // namespace pathfit::renderer
