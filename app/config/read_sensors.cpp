#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "app/config/apply_schema.h"
#include "app/config/field_of_view.h"
#include "app/config/map_reader.h"
#include "app/config/read_config.h"
#include "app/config/triple.h"

namespace pathfit::app {
namespace {

// Rows of a pose may be rounded by whoever wrote them.
constexpr double kRotationTolerance = 1e-4;

void ReadIntrinsics(YamlNode& node, SensorConfig& sensor) {
  const MapReader map(&node);
  map.Get("size_px", sensor.size_px);
  const double width = sensor.size_px[0];
  const double height = sensor.size_px[1];
  if (const YamlNode* focal = map.Find("focal_px")) {
    const std::vector<double> f = NumbersOf(*focal);
    sensor.focal_px = {f.front(), f.back()};
  } else if (map.Has("fov_deg")) {
    double degrees = 0.0;
    map.Get("fov_deg", degrees);
    const double length =
        FocalLength(degrees * std::numbers::pi / 180.0, map.TextOf("fov_axis"), width, height);
    sensor.focal_px = {length, length};
  } else if (map.Has("height_m")) {
    double metres = 0.0;
    map.Get("height_m", metres);
    sensor.focal_px = {height / metres, height / metres};
  }
  sensor.orthographic = map.TextOf("type") == "orthographic";
  sensor.principal_point_px = {0.5 * width, 0.5 * height};
  if (map.Has("principal_point_px")) {
    map.Get("principal_point_px", sensor.principal_point_px);
  } else if (map.Has("size_px")) {
    const std::string middle = fmt::format("[{}, {}]", 0.5 * width, 0.5 * height);
    node.entries.push_back({"principal_point_px", Place{}, DefaultValue(middle)});
  }
  const MapReader distortion = map.Map("distortion");
  distortion.Get("k1", sensor.k1);
  distortion.Get("k2", sensor.k2);
  distortion.Get("k3", sensor.k3);
  distortion.Get("p1", sensor.p1);
  distortion.Get("p2", sensor.p2);
  map.Get("exposure_ev", sensor.exposure_ev);
}

void ReadCrop(const MapReader& map,
              const std::string& path,
              ConfigReading& reading,
              SensorConfig& sensor) {
  const YamlNode* crop = map.Find("crop_px");
  if (crop == nullptr) return;
  const std::array<int, 4> c = {IntegerOf(crop->items[0]),
                                IntegerOf(crop->items[1]),
                                IntegerOf(crop->items[2]),
                                IntegerOf(crop->items[3])};
  sensor.crop_px = c;
  const bool empty = c[2] < 1 || c[3] < 1;
  const bool outside = c[0] + c[2] > sensor.size_px[0] || c[1] + c[3] > sensor.size_px[1];
  if (empty || (map.Has("size_px") && outside)) {
    reading.Report(crop->place,
                   path + ".crop_px",
                   fmt::format("the part [x, y, width, height] must not be empty and must lie "
                               "inside the {}x{} picture",
                               sensor.size_px[0],
                               sensor.size_px[1]));
  }
}

// Completes a filter that is a map by the radius of its shape.
void ReadFilter(YamlNode* node, SensorConfig& sensor) {
  if (node == nullptr) return;
  const std::string shape = node->IsMap() ? MapReader(node).TextOf("type") : node->text;
  if (shape != "tent" && shape != "gaussian") return;
  sensor.filter = shape == "tent" ? SensorConfig::Filter::kTent : SensorConfig::Filter::kGaussian;
  sensor.filter_radius_px = shape == "tent" ? 1.0 : 2.0;
  if (!node->IsMap()) return;
  if (node->Find("radius_px") == nullptr) {
    node->entries.push_back({"radius_px", Place{}, DefaultValue(shape == "tent" ? "1" : "2")});
  }
  MapReader(node).Get("radius_px", sensor.filter_radius_px);
  MapReader(node).Get("sigma_px", sensor.filter_sigma_px);
}

void ReadLookAt(const YamlNode& node,
                const std::string& path,
                ConfigReading& reading,
                SensorConfig& sensor) {
  const MapReader map(&node);
  map.Get("origin_m", sensor.origin);
  map.Get("target_m", sensor.target);
  map.Get("up", sensor.up);
  if (!map.Has("origin_m") || !map.Has("target_m")) return;
  const Triple view = Minus(sensor.target, sensor.origin);
  if (Norm(view) == 0.0) {
    reading.Report(
        map.Find("target_m")->place, path + ".target_m", "the target is where the camera stands");
  } else if (AreParallel(view, sensor.up)) {
    const YamlNode* up = map.Find("up");
    const bool given = up != nullptr && up->place.source != Place::Source::kDefault;
    reading.Report(given ? up->place : node.place,
                   path + ".up",
                   "up must not be zero or along the viewing direction");
  }
}

void ReadMatrix(const YamlNode& node,
                const std::string& path,
                ConfigReading& reading,
                SensorConfig& sensor) {
  sensor.look_at = false;
  auto& m = sensor.world_from_camera;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) m.at(i).at(j) = NumberOf(node.items[i].items[j]);
  }
  double error = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double dot =
          m[0].at(i) * m[0].at(j) + m[1].at(i) * m[1].at(j) + m[2].at(i) * m[2].at(j);
      error = std::max(error, std::abs(dot - (i == j ? 1.0 : 0.0)));
    }
  }
  const Triple z = Cross({m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]});
  const bool mirrored = z[0] * m[0][2] + z[1] * m[1][2] + z[2] * m[2][2] < 0.0;
  const bool last_row = m[3] == std::array<double, 4>{0.0, 0.0, 0.0, 1.0};
  if (error > kRotationTolerance || mirrored || !last_row) {
    reading.Report(node.place,
                   path,
                   "the first three columns must be a rotation (no scale, no mirror) and the last "
                   "row [0, 0, 0, 1]");
  }
}

SensorConfig ReadSensor(YamlEntry& entry, ConfigReading& reading) {
  const std::string path = "scene.sensors." + entry.key;
  SensorConfig sensor;
  sensor.name = entry.key;
  ReadIntrinsics(entry.value, sensor);
  const MapReader map(&entry.value);
  ReadCrop(map, path, reading, sensor);
  ReadFilter(entry.value.Find("filter"), sensor);
  const MapReader pose = map.Map("pose");
  if (const YamlNode* look_at = pose.Find("look_at")) {
    ReadLookAt(*look_at, path + ".pose.look_at", reading, sensor);
  } else if (const YamlNode* matrix = pose.Find("world_from_camera")) {
    ReadMatrix(*matrix, path + ".pose.world_from_camera", reading, sensor);
  }
  return sensor;
}

}  // namespace

void ReadSensors(ConfigReading& reading) {
  YamlNode* scene = reading.root.Find("scene");
  YamlNode* sensors = scene == nullptr ? nullptr : scene->Find("sensors");
  if (sensors != nullptr) {
    for (YamlEntry& entry : sensors->entries) {
      reading.config.sensors.push_back(ReadSensor(entry, reading));
    }
    if (reading.has_input) {
      reading.Report(sensors->place,
                     "scene.sensors",
                     "sensors are not supported together with input; the photos are the cameras");
    }
  }
  const bool none = sensors == nullptr || sensors->entries.empty();
  if (scene != nullptr && !reading.has_input && none) {
    reading.Report(scene->place, "scene", "there is no camera; give input or scene.sensors");
  }
}

}  // namespace pathfit::app
