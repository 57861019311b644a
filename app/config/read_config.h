#pragma once

#include <string>
#include <utility>
#include <vector>

#include "app/config/config_error.h"
#include "app/config/experiment_config.h"
#include "app/config/yaml_node.h"

namespace pathfit::app {

/// A configuration whose values are stored but not yet checked against each other: the tree they
/// came from, which the checks complete by defaults that depend on other values, and what is wrong.
struct ConfigReading {
  YamlNode root;
  bool has_input = false;  ///< given, right or wrong
  ExperimentConfig config;
  std::vector<Problem> problems;

  void Report(const Place& place, std::string path, std::string text) {
    problems.push_back({place, std::move(path), std::move(text)});
  }
};

/// A mesh of the scene by its name: of `scene.geometry`, or one of the groups of a file.
struct NamedMesh {
  std::string name;
  const GeometryConfig* geometry;
  std::string material;
};
std::vector<NamedMesh> MeshesOf(const ExperimentConfig& config);

/// Names of materials, meshes and textures; sets the textures' roles.
void CheckScene(ConfigReading& reading);
/// Sets what is free in each stage.
void CheckStages(ConfigReading& reading);

}  // namespace pathfit::app
