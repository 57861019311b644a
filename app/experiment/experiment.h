#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/config/experiment_config.h"
#include "optim/observation/observation.h"
#include "optim/round/fit_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {
class Ranks;
}

namespace pathfit::app {

/// Everything a command works on: the scene with one sensor per photo (in the order of the views)
/// or those of the config, the photos, and what is to be fitted.
struct Experiment {
  renderer::Scene scene;
  optim::ObservationSet observations;  ///< no views without `input`
  optim::FitSpec fit;
  std::vector<std::filesystem::path> input_files;  ///< in a fixed order
  std::vector<std::string> assumptions;            ///< what was taken for granted, for people
  std::vector<std::string> warnings;               ///< what of the input files is not used
  std::vector<std::string> attributions;           ///< credit lines found beside the input files
};

/// Loads photos, meshes and images and builds the scene. Throws IoError and SceneError, each naming
/// the file or object, and ConfigError as ReadUnknowns.
Experiment BuildExperiment(const ExperimentConfig& config);
/// The same with photos that were loaded already.
Experiment BuildExperiment(const ExperimentConfig& config, optim::ObservationSet photos);
/// The same on all ranks at once: the first reads all photos and says what there is, the others
/// read what they come to need. Their input_files are incomplete.
Experiment BuildExperiment(const ExperimentConfig& config, optim::Ranks& ranks);

/// The scene's meshes, materials, textures, lights and sensors; visual hulls are carved from the
/// observations of `experiment`. Adds what was read, mended and left out to its lists.
renderer::Scene BuildScene(const ExperimentConfig& config, Experiment& experiment);

/// One for each of the config, in its order, and behind them further forms of those that change
/// their form.
struct Unknowns {
  std::vector<optim::UnknownSpec> specs;
  /// By unknown of the config and stage that frees it: indices into `specs`; the last entry holds
  /// for all further stages.
  std::vector<std::vector<std::vector<int>>> of_config;
};
/// The unknowns, whose names are looked up in the scene that was built. Throws ConfigError with all
/// that is wrong with them, each at its place in the file.
Unknowns ReadUnknowns(const ExperimentConfig& config, const renderer::Scene& scene);

/// The whole configuration as YAML with the place that each value came from; it can be run again.
/// What unknowns have by default, which depends on the scene, stands there too.
std::string ResolvedYaml(const ExperimentConfig& config, const renderer::Scene& scene);

/// Unknowns, stages and loss with names resolved to the scene's objects.
optim::FitSpec BuildFitSpec(const ExperimentConfig& config, const renderer::Scene& scene);

}  // namespace pathfit::app
