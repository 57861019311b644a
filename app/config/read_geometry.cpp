#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "app/config/map_reader.h"
#include "app/config/read_config.h"
#include "app/config/triple.h"

namespace pathfit::app {
namespace {

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
  triples("normals", mesh.normals);
  if (const YamlNode* list = map.Find("uvs")) {
    for (const YamlNode& item : list->items) {
      const std::vector<double> uv = NumbersOf(item);
      mesh.uvs.push_back({uv[0], uv[1]});
    }
  }
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
  const auto one_per_vertex = [&](const char* key, const char* noun, std::size_t given) {
    if (!map.Has(key) || !map.Has("vertices") || given == mesh.vertices.size()) return;
    reading.Report(
        map.Find(key)->place,
        path + "." + key,
        fmt::format(
            "{} {} for {} vertices; one for each is needed", given, noun, mesh.vertices.size()));
  };
  one_per_vertex("colors", "colours", mesh.colors.size());
  one_per_vertex("normals", "normals", mesh.normals.size());
  one_per_vertex("uvs", "UVs", mesh.uvs.size());
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    if (!IsZero(mesh.normals[i])) continue;
    reading.Report(
        map.Find("normals")->items[i].place, path + ".normals", "a normal must not be [0, 0, 0]");
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
  if (primitive.Has("disk")) {
    DiskGeometry disk;
    primitive.Map("disk").Get("segments", disk.segments);
    return disk;
  }
  if (primitive.Has("sphere")) {
    SphereGeometry sphere;
    primitive.Map("sphere").Get("radius_m", sphere.radius);
    primitive.Map("sphere").Get("subdivisions", sphere.subdivisions);
    return sphere;
  }
  return FileGeometry{map.TextOf("file")};
}

}  // namespace

GeometryConfig ReadGeometry(const YamlEntry& entry, ConfigReading& reading) {
  const std::string path = "scene.geometry." + entry.key;
  const MapReader map(&entry.value);
  GeometryConfig geometry;
  geometry.name = entry.key;
  geometry.geometry = ReadShape(map, path, reading);
  map.Get("material", geometry.material);
  if (const YamlNode* groups = map.Find("materials")) {
    for (const YamlEntry& group : groups->entries) {
      geometry.group_materials.emplace_back(group.key, group.value.text);
    }
  }
  const std::string normals = map.TextOf("normals");
  geometry.normals = normals == "flat"     ? GeometryConfig::Normals::kFlat
                     : normals == "smooth" ? GeometryConfig::Normals::kSmooth
                     : normals == "file"   ? GeometryConfig::Normals::kFile
                                           : GeometryConfig::Normals::kDefault;
  map.Get("repair", geometry.repair);
  const MapReader transform = map.Map("transform");
  if (const YamlNode* scale = transform.Find("scale")) {
    const std::vector<double> s = NumbersOf(*scale);
    geometry.transform.scale = s.size() == 3 ? Triple{s[0], s[1], s[2]} : Triple{s[0], s[0], s[0]};
  }
  ReadRotation(
      transform, path + ".transform", reading, geometry.transform.axis, geometry.transform.angle);
  transform.Get("translate_m", geometry.transform.translate);
  if (map.Has("pivot_m")) map.Get("pivot_m", geometry.pivot.emplace());
  return geometry;
}

}  // namespace pathfit::app
