#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "renderer/math/rgb.h"
#include "renderer/math/transform.h"

namespace pathfit::renderer {

/// What a light is attached to. A camera-frame light turns and moves with the sensor that is
/// rendered (turntable, flash): its own frame is the camera's (x right, y up, -z forward).
enum class LightFrame { kWorld, kCamera };

/// Light at infinity, equirectangular texels, bilinear; direction d in the light's own frame maps
/// to u = atan2(d.x, -d.z) / (2 pi) mod 1, v = acos(d.y) / pi; texel centres at half-integers, u
/// wraps, v clamps. Radiance is intensity * texel. One texel means a constant environment.
struct EnvironmentEmitter {
  int width = 1;
  int height = 1;
  std::vector<Rgb> texels = {Rgb{1.0, 1.0, 1.0}};  ///< row 0 is the +y pole
  Rgb intensity{1.0, 1.0, 1.0};
  Mat3 frame_from_light;  ///< rotation into `frame` (world or camera)
};

struct PointEmitter {
  Vec3 position;                 ///< in `frame`
  Rgb intensity{1.0, 1.0, 1.0};  ///< radiant intensity (W/sr)
};

struct DirectionalEmitter {
  Vec3 direction{0.0, -1.0, 0.0};  ///< unit, direction in which light travels, in `frame`
  Rgb irradiance{1.0, 1.0, 1.0};   ///< on a surface facing the light
};

struct Emitter {
  std::string name;
  LightFrame frame = LightFrame::kWorld;
  std::variant<EnvironmentEmitter, PointEmitter, DirectionalEmitter> light;
};

/// The rgb factor that is the `intensity` parameter of any light (irradiance for directional).
Rgb& LightIntensity(Emitter& emitter);
const Rgb& LightIntensity(const Emitter& emitter);

/// Equirectangular map and its inverse, light's own frame <-> [0,1]^2.
Vec2 EnvironmentUv(const Vec3& direction_in_light);
Vec3 EnvironmentDirection(const Vec2& uv);

/// Bilinear lookup weights: up to four texels, weights sum to one.
struct TexelWeights {
  std::array<int, 4> texel{};
  std::array<double, 4> weight{};
};
TexelWeights EnvironmentTexelWeights(const EnvironmentEmitter& environment, const Vec2& uv);

/// intensity * texel lookup.
Rgb EnvironmentRadianceAt(const EnvironmentEmitter& environment, const Vec2& uv);

}  // namespace pathfit::renderer
