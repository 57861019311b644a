#pragma once

#include <string>
#include <utility>
#include <vector>

#include "app/config/config_error.h"
#include "app/config/experiment_config.h"
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

void ReadInput(ConfigReading& reading);
void ReadScene(ConfigReading& reading);
void ReadSensors(ConfigReading& reading);
/// After ReadInput and ReadScene.
void ReadUnknowns(ConfigReading& reading);
/// After ReadUnknowns.
void ReadStages(ConfigReading& reading);
/// render, loss, solver, output, gradcheck.
void ReadSettings(ConfigReading& reading);

}  // namespace pathfit::app
