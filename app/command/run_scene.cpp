#include "app/command/run_scene.h"

#include <algorithm>

#include "app/config/nearest_name.h"
#include "optim/checkpoint/checkpoint.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"

namespace pathfit::app {
namespace fs = std::filesystem;

RunScene LoadRunScene(CommandContext& context, const fs::path& target, const std::string& stage) {
  const RunDirectory run = OpenRunDirectory(target);
  ExperimentConfig config = LoadExperimentConfig(run.ResolvedConfig(), context.line.overrides);
  const renderer::ThreadLimit limit(NumThreads(context.line, config.threads));
  RunScene loaded{run, std::move(config), {}};
  loaded.experiment = BuildExperiment(loaded.config);
  Experiment& experiment = loaded.experiment;
  for (const std::string& text : experiment.assumptions) context.log.Info(text);
  for (const std::string& text : experiment.warnings) context.log.Warn(text);
  if (stage == "start") return loaded;
  optim::NewestCheckpoint newest =
      optim::ReadNewestCheckpoint(run.Checkpoints(), {experiment.scene, experiment.fit.unknowns});
  for (const std::string& reason : newest.damaged) {
    context.log.Warn("a checkpoint is left out, and an older one used: " + reason);
  }
  if (!newest.state) throw renderer::IoError(run.root().string() + ": the run has no checkpoint");
  if (stage.empty()) {
    experiment.scene = std::move(newest.state->scene);
    return loaded;
  }
  // What the current stage began with is what the one before it ended with.
  std::vector<std::string> known = {"start"};
  const auto next = static_cast<std::size_t>(newest.state->stage);
  if (next > 0 && next <= experiment.fit.stages.size()) {
    known.push_back(experiment.fit.stages[next - 1].name);
    if (known.back() == stage) {
      experiment.scene = std::move(newest.state->stage_start);
      return loaded;
    }
  }
  throw UsageError(context.line.command->name,
                   "--stage: the run's checkpoints have no end of a stage '" + stage +
                       "'; they have " + JoinNames(known));
}

std::vector<ExportedView> ExportedViews(const Experiment& experiment,
                                        const ExperimentConfig& config) {
  std::vector<ExportedView> views;
  for (const optim::View& view : experiment.observations.views) {
    // Of a view's files its photo comes first.
    const auto file = std::ranges::find_if(experiment.input_files, [&](const fs::path& path) {
      // Camera files may leave a photo's extension out.
      fs::path named = path;
      if (!fs::path(view.name).has_extension()) named.replace_extension();
      return named.filename() == fs::path(view.name).filename() &&
             named.generic_string().ends_with(view.name);
    });
    const fs::path path =
        file != experiment.input_files.end() ? *file : config.input->photos.images_dir / view.name;
    views.push_back({view.name, path.string(), view.validation, view.file_width, view.file_height});
  }
  return views;
}

}  // namespace pathfit::app
