#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "app/experiment/build_parts.h"
#include "app/experiment/experiment.h"
#include "app/experiment/photo_names.h"
#include "app/experiment/promotions.h"
#include "renderer/core/error.h"

namespace pathfit::app {

using renderer::SceneError;
using renderer::Vec3;

renderer::Mat3 RotationOf(const Triple& axis, double angle) {
  return renderer::RotationAboutAxis(renderer::Normalized(ToVec3(axis)), angle);
}

renderer::Camera BuildSensor(const SensorConfig& config) {
  renderer::Camera camera;
  camera.name = config.name;
  camera.width = config.size_px[0];
  camera.height = config.size_px[1];
  camera.fx = config.focal_px[0];
  camera.fy = config.focal_px[1];
  camera.cx = config.principal_point_px[0];
  camera.cy = config.principal_point_px[1];
  camera.distortion = config.distortion;
  camera.vignetting = config.vignetting;
  camera.projection = config.projection;
  camera.filter = config.filter;
  camera.gain = std::exp2(config.exposure_ev);
  if (config.look_at) {
    try {
      camera.world_from_camera =
          renderer::LookAt(ToVec3(config.origin), ToVec3(config.target), ToVec3(config.up));
    } catch (const std::invalid_argument& e) {
      throw SceneError("sensor '" + config.name + "': " + e.what());
    }
  } else {
    const auto& m = config.world_from_camera;
    const auto column = [&](std::size_t j) { return Vec3{m[0][j], m[1][j], m[2][j]}; };
    camera.world_from_camera = {{column(0), column(1), column(2)}, column(3)};
  }
  if (config.crop_px) {
    const auto& c = *config.crop_px;
    camera = renderer::CroppedCamera(camera, c[0], c[1], c[2], c[3]);
  }
  return camera;
}

namespace {

// Lights that shine in some of the photos are off for the other sensors.
void SwitchLights(const ExperimentConfig& config, renderer::Scene& scene) {
  std::vector<std::string> names;
  for (const renderer::Camera& sensor : scene.sensors) names.push_back(sensor.name);
  const PhotoNames photos(std::move(names));
  std::vector<Problem> problems;
  for (int e = 0; e < static_cast<int>(scene.emitters.size()); ++e) {
    const std::string& name = scene.emitters[static_cast<std::size_t>(e)].name;
    const auto light = std::ranges::find(config.lights, name, &LightConfig::name);
    if (light == config.lights.end() || light->photos.empty()) continue;
    const YamlNode& patterns =
        *config.resolved.Find("scene")->Find("lights")->Find(name)->Find("photos");
    for (const YamlNode& pattern : patterns.items) {
      photos.RequireMatch(
          pattern.text, pattern.place, "scene.lights." + name + ".photos", problems);
    }
    for (std::size_t i = 0; i < photos.size(); ++i) {
      const bool shines = std::ranges::any_of(
          light->photos, [&](const std::string& pattern) { return photos.Matches(pattern, i); });
      if (!shines) scene.sensors[i].lights_off.push_back(e);
    }
  }
  if (!problems.empty()) throw ConfigError(config.source, problems);
}

}  // namespace

renderer::Scene BuildScene(const ExperimentConfig& config, Experiment& experiment) {
  const optim::ObservationSet& observations = experiment.observations;
  const BuildContext context{
      observations, experiment.input_files, experiment.assumptions, experiment.warnings};
  renderer::Scene scene;
  for (const TextureConfig& texture : config.textures) {
    scene.textures.push_back(BuildTexture(texture, context));
  }
  for (const MaterialConfig& material : config.materials) {
    scene.materials.push_back(BuildMaterial(material, config));
  }
  for (const GeometryConfig& geometry : config.geometry) {
    AddMeshes(geometry, config, context, scene);
  }
  for (const LightConfig& light : config.lights) {
    if (HasName(scene.emitters, light.name)) {
      throw SceneError("light '" + light.name + "': a glTF file has brought one of this name");
    }
    scene.emitters.push_back(BuildEmitter(light, scene, context));
    if (light.type == LightConfig::Type::kEnvironment ||
        light.type == LightConfig::Type::kConstant) {
      scene.environment_visible = light.visible;
    }
  }
  if (observations.views.empty()) {
    for (const SensorConfig& sensor : config.sensors) {
      if (HasName(scene.sensors, sensor.name)) {
        throw SceneError("sensor '" + sensor.name + "': a glTF file has brought one of this name");
      }
      scene.sensors.push_back(BuildSensor(sensor));
    }
  }
  for (const optim::View& view : observations.views) {
    scene.sensors.push_back(view.camera);
    scene.sensors.back().name = view.name;
  }
  AddPromotedTextures(config, scene);
  SwitchLights(config, scene);
  renderer::ValidateScene(scene);
  return scene;
}

}  // namespace pathfit::app
