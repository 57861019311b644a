#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/experiment/build_parts.h"
#include "renderer/core/error.h"
#include "renderer/io/image_file.h"

namespace pathfit::app {
namespace {

using renderer::Mat3;
using renderer::SceneError;
using renderer::Vec3;

renderer::EnvironmentEmitter BuildEnvironment(const LightConfig& config,
                                              const BuildContext& context) {
  renderer::EnvironmentEmitter light;
  light.frame_from_light = RotationOf(config.axis, config.angle);
  light.intensity = ToRgb(config.intensity);
  if (config.type == LightConfig::Type::kConstant) {
    light.texels = {ToRgb(config.init)};
  } else if (config.file.empty()) {
    light.width = config.size_px[0];
    light.height = config.size_px[1];
    light.texels.assign(
        static_cast<std::size_t>(light.width) * static_cast<std::size_t>(light.height),
        ToRgb(config.init));
  } else {
    context.files.push_back(config.file);
    ReadEnvironmentFile(config.file, "light '" + config.name + "'", light);
  }
  return light;
}

}  // namespace

void ReadEnvironmentFile(const std::filesystem::path& path,
                         const std::string& name,
                         renderer::EnvironmentEmitter& light) {
  const renderer::DecodedImage decoded = renderer::ReadImageFile(path, false);
  if (!decoded.linear) {
    throw SceneError(name + ": " + path.string() +
                     " is an 8- or 16-bit picture; an environment needs linear radiance (.exr or "
                     ".hdr)");
  }
  light.width = decoded.image.width;
  light.height = decoded.image.height;
  light.texels.clear();
  for (int y = 0; y < light.height; ++y) {
    for (int x = 0; x < light.width; ++x) light.texels.push_back(decoded.image.ColorAt(x, y));
  }
}

renderer::EnvironmentEmitter ReadUprightEnvironment(const std::filesystem::path& path,
                                                    const std::string& name,
                                                    const Vec3& up) {
  renderer::EnvironmentEmitter light;
  ReadEnvironmentFile(path, name, light);
  const Vec3 axis = Cross(Vec3{0.0, 1.0, 0.0}, up);
  if (Norm(axis) > 0.0) {
    light.frame_from_light =
        renderer::RotationAboutAxis(Normalized(axis), std::atan2(Norm(axis), up.y));
  } else if (up.y < 0.0) {
    light.frame_from_light = renderer::RotationAboutAxis({1.0, 0.0, 0.0}, std::numbers::pi);
  }
  return light;
}

namespace {

// Looks along the light's direction, then turned.
Mat3 FrameOf(const LightConfig& config, const Vec3& up) {
  const Mat3 aim = renderer::LookAt({0.0, 0.0, 0.0}, ToVec3(config.direction), up).linear;
  return RotationOf(config.axis, config.angle) * aim;
}

renderer::SpotEmitter BuildSpot(const LightConfig& config) {
  // A cone is round: any direction across its axis will do.
  constexpr double kNearlyUp = 0.9;
  const Vec3 axis = renderer::Normalized(ToVec3(config.direction));
  const Vec3 up = std::abs(axis.y) < kNearlyUp ? Vec3{0.0, 1.0, 0.0} : Vec3{0.0, 0.0, 1.0};
  renderer::SpotEmitter light;
  light.position = ToVec3(config.position);
  light.frame_from_light = FrameOf(config, up);
  light.intensity = ToRgb(config.intensity);
  light.inner_angle = config.inner_angle;
  light.outer_angle = config.outer_angle;
  return light;
}

template <class List>
int IndexByName(const List& list, const std::string& name) {
  const auto found = std::ranges::find_if(list, [&](const auto& x) { return x.name == name; });
  return found == list.end() ? -1 : static_cast<int>(found - list.begin());
}

renderer::ProjectorEmitter BuildProjector(const LightConfig& config, const renderer::Scene& scene) {
  renderer::ProjectorEmitter light;
  light.position = ToVec3(config.position);
  light.frame_from_light = FrameOf(config, ToVec3(config.up));
  light.intensity = ToRgb(config.intensity);
  light.texture = IndexByName(scene.textures, config.texture);
  const renderer::Texture& picture = scene.textures[static_cast<std::size_t>(light.texture)];
  const double focal = FocalLength(config.fov, config.fov_axis, picture.width, picture.height);
  light.tan_half_width = 0.5 * picture.width / focal;
  light.tan_half_height = 0.5 * picture.height / focal;
  return light;
}

renderer::AreaEmitter BuildArea(const LightConfig& config, const renderer::Scene& scene) {
  renderer::AreaEmitter light;
  light.mesh = IndexByName(scene.meshes, config.mesh);
  if (light.mesh < 0) {
    throw SceneError("light '" + config.name + "': mesh '" + config.mesh +
                     "' has no triangles left; all of its groups have names of their own");
  }
  light.intensity = ToRgb(config.intensity);
  light.texture = IndexByName(scene.textures, config.texture);
  light.two_sided = config.two_sided;
  return light;
}

renderer::DirectionalEmitter BuildDirectional(const LightConfig& config) {
  const Vec3 direction = RotationOf(config.axis, config.angle) * ToVec3(config.direction);
  return {renderer::Normalized(direction), ToRgb(config.intensity)};
}

using AnyLight = decltype(renderer::Emitter::light);

AnyLight BuildLight(const LightConfig& config,
                    const renderer::Scene& scene,
                    const BuildContext& context) {
  switch (config.type) {
    case LightConfig::Type::kEnvironment:
    case LightConfig::Type::kConstant:
      return BuildEnvironment(config, context);
    case LightConfig::Type::kPoint:
      return renderer::PointEmitter{ToVec3(config.position), ToRgb(config.intensity)};
    case LightConfig::Type::kDirectional:
      return BuildDirectional(config);
    case LightConfig::Type::kSpot:
      return BuildSpot(config);
    case LightConfig::Type::kProjector:
      return BuildProjector(config, scene);
    case LightConfig::Type::kArea:
      break;
  }
  return BuildArea(config, scene);
}

}  // namespace

renderer::Emitter BuildEmitter(const LightConfig& config,
                               const renderer::Scene& scene,
                               const BuildContext& context) {
  return {config.name,
          config.camera_frame ? renderer::LightFrame::kCamera : renderer::LightFrame::kWorld,
          {},
          BuildLight(config, scene, context)};
}

}  // namespace pathfit::app
