#pragma once

#include <string>
#include <utility>
#include <vector>

#include "app/config/config_error.h"
#include "app/config/experiment_config.h"
#include "app/config/map_reader.h"
#include "app/config/yaml_node.h"

namespace pathfit::app {

/// What the readers of the parts share: the tree that ApplySchema accepted, which they complete by
/// defaults that depend on other values; the result; and what is wrong between values.
struct ConfigReading {
  YamlNode root;
  bool has_input = false;  ///< given, right or wrong
  ExperimentConfig config;
  std::vector<Problem> problems;

  void Report(const Place& place, std::string path, std::string text) {
    problems.push_back({place, std::move(path), std::move(text)});
  }
};

// Items of the scene.
GeometryConfig ReadGeometry(const YamlEntry& entry, ConfigReading& reading);
MaterialConfig ReadMaterial(const YamlEntry& entry, ConfigReading& reading);
LightConfig ReadLight(YamlEntry& entry, ConfigReading& reading);
/// `rotate` of a map, if it has one.
void ReadRotation(const MapReader& map,
                  const std::string& path,
                  ConfigReading& reading,
                  Triple& axis,
                  double& angle);

/// The textures; then UseTexture for every name of one, which says what it means; then
/// CheckTextures.
void ReadTextures(ConfigReading& reading);
void UseTexture(const YamlNode& name,
                const std::string& path,
                TextureConfig::Role role,
                ConfigReading& reading);
void CheckTextures(ConfigReading& reading);

/// A mesh of the scene by its name: of `scene.geometry`, or one of the groups of a file.
struct NamedMesh {
  std::string name;
  const GeometryConfig* geometry;
  std::string material;
};
std::vector<NamedMesh> MeshesOf(const ExperimentConfig& config);

void ReadInput(ConfigReading& reading);
void ReadScene(ConfigReading& reading);
void ReadSensors(ConfigReading& reading);
/// Names and whether they are held; the rest waits for the scene.
void ReadUnknowns(ConfigReading& reading);
/// After ReadUnknowns.
void ReadStages(ConfigReading& reading);
/// render, loss, solver, output, gradcheck.
void ReadSettings(ConfigReading& reading);

}  // namespace pathfit::app
