#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/command/command_line.h"
#include "app/config/experiment_config.h"
#include "app/experiment/experiment.h"
#include "app/output/export_result.h"
#include "app/output/run_directory.h"

namespace pathfit::app {

/// What commands do with a run: its experiment, with the scene of one of its states.
struct RunScene {
  RunDirectory run;
  ExperimentConfig config;
  Experiment experiment;
};

/// `stage`: "start" for the scene that the run began with, the name of a stage for the scene at its
/// end as far as a checkpoint has it, empty for the newest state. Damaged checkpoints are said in
/// the log. Throws IoError (no run, no checkpoint), and UsageError for a stage that is not there.
RunScene LoadRunScene(CommandContext& context,
                      const std::filesystem::path& target,
                      const std::string& stage);

/// Names, files and roles of the photos of an experiment, in the order of its views.
std::vector<ExportedView> ExportedViews(const Experiment& experiment,
                                        const ExperimentConfig& config);

}  // namespace pathfit::app
