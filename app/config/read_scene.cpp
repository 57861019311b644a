#include <algorithm>
#include <numbers>

#include <fmt/format.h>

#include "app/config/map_reader.h"
#include "app/config/nearest_name.h"
#include "app/config/read_config.h"

namespace pathfit::app {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

bool IsZero(const Triple& v) { return v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0; }

void ReadRotation(const MapReader& map,
                  const std::string& path,
                  ConfigReading& reading,
                  Triple& axis,
                  double& angle) {
  const MapReader rotate = map.Map("rotate");
  double degrees = 0.0;
  rotate.Get("axis", axis);
  rotate.Get("angle_deg", degrees);
  angle = degrees * kRadiansPerDegree;
  if (IsZero(axis)) {
    reading.Report(
        rotate.Find("axis")->place, path + ".rotate.axis", "the axis must not be [0, 0, 0]");
  }
}

InlineGeometry ReadInlineMesh(const MapReader& map,
                              const std::string& path,
                              ConfigReading& reading) {
  InlineGeometry mesh;
  const auto triples = [&map](const char* key, std::vector<Triple>& out) {
    const YamlNode* list = map.Find(key);
    if (list == nullptr) return;
    for (const YamlNode& item : list->items) {
      const std::vector<double> v = NumbersOf(item);
      out.push_back({v[0], v[1], v[2]});
    }
  };
  triples("vertices", mesh.vertices);
  triples("colors", mesh.colors);
  const auto count = static_cast<int>(mesh.vertices.size());
  if (const YamlNode* list = map.Find("triangles")) {
    for (const YamlNode& item : list->items) {
      const std::array<int, 3> t = {
          IntegerOf(item.items[0]), IntegerOf(item.items[1]), IntegerOf(item.items[2])};
      const int largest = *std::max_element(t.begin(), t.end());
      if (map.Has("vertices") && largest >= count) {
        reading.Report(
            item.place,
            path + ".triangles",
            fmt::format("there is no vertex {}; there are {}, counted from 0", largest, count));
      }
      mesh.triangles.push_back(t);
    }
  }
  if (map.Has("colors") && map.Has("vertices") && mesh.colors.size() != mesh.vertices.size()) {
    reading.Report(map.Find("colors")->place,
                   path + ".colors",
                   fmt::format("{} colours for {} vertices; one for each is needed",
                               mesh.colors.size(),
                               mesh.vertices.size()));
  }
  return mesh;
}

Geometry ReadShape(const MapReader& map, const std::string& path, ConfigReading& reading) {
  if (map.Has("mesh")) return ReadInlineMesh(map.Map("mesh"), path + ".mesh", reading);
  if (map.Has("visual_hull")) {
    VisualHullGeometry hull;
    map.Map("visual_hull").Get("resolution", hull.resolution);
    const auto& input = reading.config.input;
    if (!input || !input->has_masks || !input->masks_silhouette) {
      reading.Report(map.Find("visual_hull")->place,
                     path + ".visual_hull",
                     "a visual hull is carved from masks; input.masks with meaning: silhouette is "
                     "needed");
    }
    return hull;
  }
  const MapReader primitive = map.Map("primitive");
  if (primitive.Has("rectangle")) return RectangleGeometry{};
  if (primitive.Has("cube")) return CubeGeometry{};
  if (primitive.Has("sphere")) {
    SphereGeometry sphere;
    primitive.Map("sphere").Get("radius_m", sphere.radius);
    primitive.Map("sphere").Get("subdivisions", sphere.subdivisions);
    return sphere;
  }
  return FileGeometry{map.TextOf("file")};
}

GeometryConfig ReadGeometry(const YamlEntry& entry, ConfigReading& reading) {
  const std::string path = "scene.geometry." + entry.key;
  const MapReader map(&entry.value);
  GeometryConfig geometry;
  geometry.name = entry.key;
  geometry.geometry = ReadShape(map, path, reading);
  map.Get("material", geometry.material);
  const MapReader transform = map.Map("transform");
  if (const YamlNode* scale = transform.Find("scale")) {
    const std::vector<double> s = NumbersOf(*scale);
    geometry.transform.scale = s.size() == 3 ? Triple{s[0], s[1], s[2]} : Triple{s[0], s[0], s[0]};
  }
  ReadRotation(
      transform, path + ".transform", reading, geometry.transform.axis, geometry.transform.angle);
  transform.Get("translate_m", geometry.transform.translate);
  return geometry;
}

MaterialConfig ReadMaterial(const YamlEntry& entry) {
  const MapReader map(&entry.value);
  MaterialConfig material;
  material.name = entry.key;
  material.metallic_roughness = map.TextOf("model") == "metallic_roughness";
  const MapReader base_color = map.Map("base_color");
  base_color.Get("constant", material.base_color);
  if (const YamlNode* vertex = base_color.Find("vertex")) {
    material.base_color_source = vertex->IsList() ? MaterialConfig::BaseColor::kVertexConstant
                                                  : MaterialConfig::BaseColor::kVertexOfMesh;
    base_color.Get("vertex", material.base_color);
  }
  map.Map("roughness").Get("constant", material.roughness);
  map.Map("metallic").Get("constant", material.metallic);
  map.Get("two_sided", material.two_sided);
  return material;
}

LightConfig ReadLight(const YamlEntry& entry, ConfigReading& reading) {
  const std::string path = "scene.lights." + entry.key;
  const MapReader map(&entry.value);
  LightConfig light;
  light.name = entry.key;
  const std::string type = map.TextOf("type");
  light.type = type == "constant"      ? LightConfig::Type::kConstant
               : type == "point"       ? LightConfig::Type::kPoint
               : type == "directional" ? LightConfig::Type::kDirectional
                                       : LightConfig::Type::kEnvironment;
  light.camera_frame = map.TextOf("frame") == "camera";
  map.Get("visible", light.visible);
  map.Get("file", light.file);
  map.Get("size_px", light.size_px);
  map.Map("init").Get("constant", light.init);
  map.Get("radiance", light.init);
  map.Get("intensity", light.intensity);
  map.Get("irradiance", light.intensity);
  ReadRotation(map, path, reading, light.axis, light.angle);
  map.Get("position_m", light.position);
  map.Get("direction", light.direction);
  if (IsZero(light.direction)) {
    reading.Report(
        map.Find("direction")->place, path + ".direction", "the direction must not be [0, 0, 0]");
  }
  return light;
}

// Every material that is named exists, and there is one environment at most.
void CheckReferences(const YamlNode& scene, ConfigReading& reading) {
  std::vector<std::string> names;
  if (const YamlNode* materials = scene.Find("materials")) {
    for (const YamlEntry& entry : materials->entries) names.push_back(entry.key);
    if (const YamlNode* meshes = scene.Find("geometry")) {
      for (const YamlEntry& entry : meshes->entries) {
        const YamlNode* name = entry.value.Find("material");
        if (name == nullptr || std::find(names.begin(), names.end(), name->text) != names.end()) {
          continue;
        }
        reading.Report(name->place,
                       "scene.geometry." + entry.key + ".material",
                       "no material is called '" + name->text + "'" + NameHint(name->text, names));
      }
    }
  }
  const YamlNode* lights = scene.Find("lights");
  if (lights == nullptr) return;
  std::string first;
  for (const YamlEntry& entry : lights->entries) {
    const YamlNode* type = entry.value.Find("type");
    if (type == nullptr || (type->text != "envmap" && type->text != "constant")) continue;
    if (first.empty()) {
      first = entry.key;
    } else {
      reading.Report(type->place,
                     "scene.lights." + entry.key,
                     "only one light may be an envmap or constant; '" + first + "' is one already");
    }
  }
}

}  // namespace

void ReadScene(ConfigReading& reading) {
  const YamlNode* scene = reading.root.Find("scene");
  if (scene == nullptr) return;
  ExperimentConfig& config = reading.config;
  if (const YamlNode* map = scene->Find("geometry")) {
    for (const YamlEntry& entry : map->entries) {
      config.geometry.push_back(ReadGeometry(entry, reading));
    }
  }
  if (const YamlNode* map = scene->Find("materials")) {
    for (const YamlEntry& entry : map->entries) config.materials.push_back(ReadMaterial(entry));
  }
  if (const YamlNode* map = scene->Find("lights")) {
    for (const YamlEntry& entry : map->entries) {
      config.lights.push_back(ReadLight(entry, reading));
    }
  }
  CheckReferences(*scene, reading);
}

}  // namespace pathfit::app
