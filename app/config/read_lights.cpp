#include <algorithm>
#include <numbers>

#include <fmt/format.h>

#include "app/config/apply_schema.h"
#include "app/config/map_reader.h"
#include "app/config/read_config.h"
#include "app/config/triple.h"

namespace pathfit::app {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

LightConfig::Type TypeOf(const std::string& word) {
  using Type = LightConfig::Type;
  if (word == "constant") return Type::kConstant;
  if (word == "point") return Type::kPoint;
  if (word == "directional") return Type::kDirectional;
  if (word == "spot") return Type::kSpot;
  if (word == "projector") return Type::kProjector;
  if (word == "area" || word == "rectangle") return Type::kArea;
  return Type::kEnvironment;
}

void ReadAim(const MapReader& map,
             const std::string& path,
             ConfigReading& reading,
             LightConfig& light) {
  map.Get("position_m", light.position);
  map.Get("direction", light.direction);
  map.Get("up", light.up);
  if (const YamlNode* target = map.Find("target_m")) {
    Triple point{};
    map.Get("target_m", point);
    light.direction = Minus(point, light.position);
    if (map.Has("position_m") && IsZero(light.direction)) {
      reading.Report(target->place, path + ".target_m", "the target is where the light stands");
      return;
    }
  } else if (IsZero(light.direction)) {
    reading.Report(
        map.Find("direction")->place, path + ".direction", "the direction must not be [0, 0, 0]");
    return;
  }
  const bool aimed = map.Has("direction") || (map.Has("target_m") && map.Has("position_m"));
  const YamlNode* up = map.Find("up");
  if (light.type == LightConfig::Type::kProjector && aimed && up != nullptr &&
      AreParallel(light.direction, light.up)) {
    const bool given = up->place.source != Place::Source::kDefault;
    const YamlNode* aim = map.Has("target_m") ? map.Find("target_m") : map.Find("direction");
    reading.Report(given ? up->place : aim->place,
                   path + ".up",
                   "up must not be zero or along the direction of the light");
  }
}

void ReadCone(YamlNode& node, const std::string& path, ConfigReading& reading, LightConfig& light) {
  constexpr double kInnerShare = 0.75;
  const MapReader map(&node);
  double outer = 0.0;
  map.Get("outer_deg", outer);
  double inner = kInnerShare * outer;
  if (const YamlNode* given = map.Find("inner_deg")) {
    map.Get("inner_deg", inner);
    if (map.Has("outer_deg") && inner >= outer) {
      reading.Report(given->place,
                     path + ".inner_deg",
                     fmt::format("inner_deg {} must be below outer_deg {}", inner, outer));
    }
  } else if (map.Has("outer_deg")) {
    node.entries.push_back({"inner_deg", Place{}, DefaultValue(fmt::format("{}", inner))});
  }
  light.outer_angle = outer * kRadiansPerDegree;
  light.inner_angle = inner * kRadiansPerDegree;
}

// A rectangle is a black mesh that shines: derivatives, shadows and exports need to know no more.
void AddRectangle(const MapReader& map,
                  const std::string& path,
                  ConfigReading& reading,
                  LightConfig& light) {
  ExperimentConfig& config = reading.config;
  const auto is_taken = [&](const auto& list) {
    return std::any_of(
        list.begin(), list.end(), [&](const auto& item) { return item.name == light.name; });
  };
  if (is_taken(config.materials) || is_taken(MeshesOf(config))) {
    reading.Report(
        map.Find("type")->place, path, "a rectangle needs a name that no mesh and no material has");
    return;
  }
  light.mesh = light.name;
  GeometryConfig& geometry = config.geometry.emplace_back();
  geometry.name = geometry.material = light.name;
  geometry.geometry = RectangleGeometry{};
  double width = 0.0;
  double height = 0.0;
  map.Get("width_m", width);
  map.Get("height_m", height);
  geometry.transform = {{0.5 * width, 0.5 * height, 1.0}, light.axis, light.angle, light.position};
  MaterialConfig& material = config.materials.emplace_back();
  material.name = light.name;
  material.base_color = {0.0, 0.0, 0.0};
}

}  // namespace

LightConfig ReadLight(YamlEntry& entry, ConfigReading& reading) {
  const std::string path = "scene.lights." + entry.key;
  const MapReader map(&entry.value);
  LightConfig light;
  light.name = entry.key;
  light.type = TypeOf(map.TextOf("type"));
  light.camera_frame = map.TextOf("frame") == "camera";
  map.Get("visible", light.visible);
  map.Get("file", light.file);
  map.Get("size_px", light.size_px);
  map.Map("init").Get("constant", light.init);
  map.Get("radiance", light.type == LightConfig::Type::kArea ? light.intensity : light.init);
  map.Get("intensity", light.intensity);
  map.Get("irradiance", light.intensity);
  ReadRotation(map, path, reading, light.axis, light.angle);
  ReadAim(map, path, reading, light);
  if (light.type == LightConfig::Type::kSpot) ReadCone(entry.value, path, reading, light);
  double fov_deg = 0.0;
  map.Get("fov_deg", fov_deg);
  if (map.Has("fov_deg")) light.fov = fov_deg * kRadiansPerDegree;
  map.Get("fov_axis", light.fov_axis);
  map.Get("mesh", light.mesh);
  map.Get("two_sided", light.two_sided);
  if (const YamlNode* texture = map.Find("texture")) {
    light.texture = texture->text;
    UseTexture(*texture, path + ".texture", TextureConfig::Role::kLight, reading);
  }
  if (map.TextOf("type") == "rectangle") AddRectangle(map, path, reading, light);
  return light;
}

}  // namespace pathfit::app
