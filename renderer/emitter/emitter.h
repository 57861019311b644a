#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>

#include "renderer/core/shared_vector.h"
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
  SharedVector<Rgb> texels = {Rgb{1.0, 1.0, 1.0}};  ///< row 0 is the +y pole
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

/// Point light with a cone: full intensity within `inner_angle` of its axis, none beyond
/// `outer_angle`, between them smoothstep of the cosine.
struct SpotEmitter {
  Vec3 position;                 ///< in `frame`
  Mat3 frame_from_light;         ///< the light looks along -z of its own frame
  Rgb intensity{1.0, 1.0, 1.0};  ///< radiant intensity inside the inner cone (W/sr)
  double inner_angle = 0.2;      ///< radians from the axis, 0 <= inner < outer < pi / 2
  double outer_angle = 0.4;
};

/// Casts a texture like a slide: a point light at `position`, looking along -z of its own frame (x
/// right, y up in the picture). A facing surface at depth z along the axis, seen under the angle t
/// from it, receives the irradiance intensity * texture * pi / (z^2 cos t).
struct ProjectorEmitter {
  Vec3 position;                 ///< in `frame`
  Mat3 frame_from_light;         ///< rotation
  double tan_half_width = 0.3;   ///< half the picture's width at depth 1
  double tan_half_height = 0.3;  ///< half its height at depth 1
  Rgb intensity{1.0, 1.0, 1.0};
  int texture = -1;  ///< into Scene::textures; nothing is cast beside the picture
};

/// A mesh that shines from the side its normals point to: radiance intensity * texture (if any).
struct AreaEmitter {
  int mesh = -1;  ///< into Scene::meshes
  Rgb intensity{1.0, 1.0, 1.0};
  int texture = -1;        ///< into Scene::textures, by the mesh's UVs; -1: the same everywhere
  bool two_sided = false;  ///< shines from both sides
};

struct Emitter {
  std::string name;
  LightFrame frame = LightFrame::kWorld;  ///< area lights: kWorld, their mesh places them
  /// Rotation vector (axis times radians, right-handed) that turns the light within `frame`, after
  /// its own orientation; not for points and areas.
  Vec3 rotation{0.0, 0.0, 0.0};
  std::variant<EnvironmentEmitter,
               PointEmitter,
               DirectionalEmitter,
               SpotEmitter,
               ProjectorEmitter,
               AreaEmitter>
      light;
};

/// Where a light points that is the same all around that direction: unit, in its frame, before
/// Emitter::rotation.
std::optional<Vec3> AxisOfSymmetry(const Emitter& emitter);

/// The rgb factor that is the `intensity` parameter of any light (irradiance for directional).
Rgb& LightIntensity(Emitter& emitter);
const Rgb& LightIntensity(const Emitter& emitter);
/// What people call its kind: "environment", "point", "directional", "spot", "projector", "area".
const char* LightWord(const Emitter& emitter);
/// Index into Scene::textures of what an area light or projector shines; -1: none.
int LightTexture(const Emitter& emitter);

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

/// Derivative of the radiance by a unit direction of the light's own frame, per channel;
/// tangential. The slope of one side at the borders of the bilinear squares; finite everywhere
/// (within 1e-6 rad of a pole, where the map has no derivative, its part along u fades to zero).
std::array<Vec3, 3> EnvironmentGradient(const EnvironmentEmitter& environment,
                                        const Vec3& direction_in_light);

}  // namespace pathfit::renderer
