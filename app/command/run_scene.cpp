#include "app/command/run_scene.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/config/nearest_name.h"
#include "optim/checkpoint/checkpoint.h"
#include "optim/ranks/ranks.h"
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
  // The first rank says it for all: photos are read as a whole for it.
  const std::vector<std::string> changed = context.ranks.IsFirst()
                                               ? ChangedInputs(ReadRunRecord(run.Record()))
                                               : std::vector<std::string>();
  if (!changed.empty()) {
    context.log.Warn(
        fmt::format("{} of the run's files have changed since it began, {} first: what is read of "
                    "them now is not what was fitted",
                    changed.size(),
                    changed.front()));
  }
  if (stage == "start") return loaded;
  const optim::FitOrigin origin{experiment.scene, experiment.fit.unknowns};
  if (!stage.empty()) {
    std::vector<std::string> known = {"start"};
    for (std::size_t i = 0; i < experiment.fit.stages.size(); ++i) {
      std::optional<renderer::Scene> end =
          optim::ReadStageEnd(run.Checkpoints(), origin, static_cast<int>(i));
      if (!end) continue;
      known.push_back(experiment.fit.stages[i].name);
      if (known.back() != stage) continue;
      experiment.scene = std::move(*end);
      return loaded;
    }
    throw UsageError(context.line.command->name,
                     "--stage: the run's checkpoints have no end of a stage '" + stage +
                         "'; they have " + JoinNames(known));
  }
  optim::NewestCheckpoint newest = optim::ReadNewestCheckpoint(run.Checkpoints(), origin);
  for (const std::string& reason : newest.damaged) {
    context.log.Warn("a checkpoint is left out, and an older one used: " + reason);
  }
  if (!newest.state) throw renderer::IoError(run.root().string() + ": the run has no checkpoint");
  experiment.scene = std::move(newest.state->scene);
  return loaded;
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
