#include "app/config/experiment_config.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/config/read_config.h"
#include "app/config/schema.h"
#include "app/config/yaml_document.h"
#include "renderer/io/mesh_file.h"

namespace pathfit::app {
namespace {

// With '_' for what a name may not hold.
std::string NameFrom(std::string text) {
  for (char& c : text) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (!letter && !(c >= '0' && c <= '9') && c != '-') c = '_';
  }
  return text.empty() ? "run" : text;
}

void CompleteName(const std::filesystem::path& path, ConfigReading& reading) {
  if (reading.root.Find("name") != nullptr) return;
  reading.config.name = NameFrom(path.stem().string());
  SetDefault(reading.root, "name", "\"" + reading.config.name + "\"");
}

// Keys in the order of the schema, wherever they came from.
void SortLikeSchema(const SchemaNode& schema, YamlNode& root) {
  std::vector<YamlEntry> sorted;
  for (const SchemaNode& child : schema.children) {
    for (YamlEntry& entry : root.entries) {
      if (entry.key == child.key) sorted.push_back(std::move(entry));
    }
  }
  root.entries = std::move(sorted);
}

std::map<std::string, std::string> PlacesOf(const ConfigReading& reading,
                                            const ConfigSource& source) {
  const std::multimap<std::string, std::string> words = {{"geometry", "mesh"},
                                                         {"geometry", "geometry"},
                                                         {"materials", "material"},
                                                         {"textures", "texture"},
                                                         {"lights", "light"},
                                                         {"sensors", "camera"},
                                                         {"sensors", "sensor"}};
  std::map<std::string, std::string> places;
  const YamlNode& scene = *reading.root.Find("scene");
  for (const auto& [list, word] : words) {
    const YamlNode* items = scene.Find(list);
    if (items == nullptr) continue;
    for (const YamlEntry& entry : items->entries) {
      places[word + " '" + entry.key + "'"] = FormatPlace(source, entry.key_place);
    }
  }
  for (const NamedMesh& mesh : MeshesOf(reading.config)) {
    const auto geometry = places.find("mesh '" + mesh.geometry->name + "'");
    const std::string place = geometry != places.end()
                                  ? geometry->second
                                  : places["light '" + mesh.name + "'"];  // a rectangle
    places["mesh '" + mesh.name + "'"] = place;
  }
  return places;
}

}  // namespace

std::string GroupMeshName(const std::string& geometry, const std::string& usemtl) {
  return geometry + "-" + NameFrom(usemtl);
}

bool IsGltf(const GeometryConfig& geometry) {
  const auto* file = std::get_if<FileGeometry>(&geometry.geometry);
  return file != nullptr && renderer::HoldsScene(file->path);
}

double FocalLength(double fov, FovAxis axis, double width, double height) {
  const double side = axis == FovAxis::kX          ? width
                      : axis == FovAxis::kY        ? height
                      : axis == FovAxis::kLarger   ? std::max(width, height)
                      : axis == FovAxis::kDiagonal ? std::hypot(width, height)
                                                   : std::min(width, height);
  return 0.5 * side / std::tan(0.5 * fov);
}

ExperimentConfig LoadExperimentConfig(const std::filesystem::path& path,
                                      const std::vector<ConfigOverride>& overrides) {
  return ReadExperimentConfig(LoadYamlFile(path), path, overrides);
}

ExperimentConfig ReadExperimentConfig(YamlDocument document,
                                      const std::filesystem::path& path,
                                      const std::vector<ConfigOverride>& overrides) {
  document.source.overrides = overrides;
  ConfigReading reading;
  reading.problems = std::move(document.problems);
  reading.root = std::move(document.root);
  reading.config.path = std::filesystem::absolute(path).lexically_normal();

  const SchemaNode& schema = ConfigSchema();
  ApplyOverrides(schema, overrides, reading.root, reading.problems);
  reading.has_input = reading.root.Find("input") != nullptr;
  ApplySchema(schema, reading.config.path.parent_path(), reading.root, reading.problems);
  CompleteName(path, reading);
  BindValues(schema, reading.root, "", &reading.config, reading.problems);
  reading.config.derivative.ApplyTo(reading.config.render);
  CheckScene(reading);
  CheckStages(reading);
  if (!reading.problems.empty()) throw ConfigError(document.source, reading.problems);

  reading.config.places = PlacesOf(reading, document.source);
  SortLikeSchema(schema, reading.root);
  reading.config.given_text = std::move(document.text);
  reading.config.resolved = std::move(reading.root);
  reading.config.source = std::move(document.source);
  return std::move(reading.config);
}

}  // namespace pathfit::app
