#include <cstdio>
#include <optional>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/command/run_scene.h"
#include "app/command/stop_signals.h"
#include "app/experiment/build_parts.h"
#include "app/experiment/orbit.h"
#include "app/output/evaluation.h"
#include "app/output/report.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app::eval_command {
namespace {

namespace fs = std::filesystem;

/// The scene of a config, a run, or of what synth has written.
renderer::Scene LoadTruth(CommandContext& context, const fs::path& path) {
  for (const fs::path& written : {path / "truth" / "scene.yaml", path / "scene.yaml"}) {
    if (fs::is_regular_file(written)) {
      return BuildExperiment(LoadExperimentConfig(written, {})).scene;
    }
  }
  if (!fs::is_directory(path)) return BuildExperiment(LoadExperimentConfig(path, {})).scene;
  if (!fs::exists(path / "run.json") && !fs::exists(path / "latest")) {
    throw renderer::IoError(path.string() +
                            ": is no truth: neither a folder of pathfit synth (truth/scene.yaml) "
                            "nor a run, nor a config");
  }
  return std::move(LoadRunScene(context, path, "").experiment.scene);
}

struct Options {
  fs::path truth;  ///< config, run, or folder of synth
  fs::path environment, output;
  std::string stage;
  int points = 50000, spp = 64;
};

void Declare(OptionList& options, Options& own) {
  options.Threads();
  options.Path(
      "--truth", "PATH", "Folder of pathfit synth, config or run to compare with", own.truth);
  options.Path(
      "--env", "FILE", "EXR or HDR that lights both anew; else a sky and a sun", own.environment);
  options.Text("--stage", "STAGE", "State after a stage, or start; else the newest", own.stage);
  options.Whole("--spp", "Samples per pixel", 2, 65536, own.spp);
  options.Whole("--points", "Points of each surface", 100, 10000000, own.points);
  options.Path("-o,--output", "FILE", "Page to write; else evaluation.html in the run", own.output);
  options.Check([&options, &own] {
    if (options.Given("--env") && own.truth.empty()) options.Fail("--env needs --truth");
    if (options.Given("--points") && own.truth.empty()) options.Fail("--points needs --truth");
  });
}

constexpr ResultKey kResult[] = {
    {"run", "text", "The run directory"},
    {"truth", "text or null", "What it was compared with"},
    {"image_scale", "number", "Of the pictures: that of the last stage"},
    {"held_out", "map", "Means over held-out photos: psnr_srgb_db, psnr_linear_db, ssim, iou"},
    {"fitted", "map", "The same over fitted photos"},
    {"views", "list", "The same for each photo"},
    {"relit", "map or absent", "With a truth: means under another light"},
    {"relit_views", "list or absent", "The same for each view"},
    {"surfaces", "list", "Distances and angles between the surfaces"},
    {"appearance", "list", "base_color, roughness, metallic at points of the truth"},
    {"parameters", "list", "Errors of each unknown that the truth has"},
    {"lights", "list", "Errors of lights"},
    {"cameras", "list", "Errors of cameras"},
    {"notes", "list", "What could not be compared, and why"},
    {"page", "text", "The page that was written"}};

ExitStatus Run(CommandContext& context, const Options& own) {
  const CommandLine& line = context.line;
  const RunScene loaded = LoadRunScene(context, line.target, own.stage);
  const renderer::ThreadLimit limit(NumThreads(line, loaded.config.threads));
  std::optional<renderer::Scene> truth;
  if (!own.truth.empty()) truth = LoadTruth(context, own.truth);
  const StopSignals signals;
  EvaluationOptions options;
  options.spp = own.spp;
  options.points = own.points;
  options.cancel = &signals.flag();
  if (!own.environment.empty()) {
    options.environment =
        ReadUprightEnvironment(own.environment, "--env", UpDirection(loaded.experiment.scene));
    options.environment_name = own.environment.filename().string();
  }
  Evaluation evaluation;
  try {
    evaluation = Evaluate(loaded.experiment, truth ? &*truth : nullptr, options);
  } catch (const renderer::Cancelled&) {
    return signals.Received().value_or(ExitStatus::kStopped);
  }
  Json figures = {{"run", loaded.run.root().string()},
                  {"truth", truth ? Json(fs::absolute(own.truth).string()) : Json(nullptr)}};
  figures.update(EvaluationJson(evaluation));
  const fs::path page =
      fs::absolute(own.output.empty() ? loaded.run.root() / "evaluation.html" : own.output);
  renderer::WriteFileAtomically(page, ReportPage(EvaluationPage(evaluation, figures)));
  if (line.json) {
    figures["page"] = page.string();
    PrintResult(context, std::move(figures));
  } else {
    fmt::print("{}", EvaluationText(evaluation));
  }
  context.log.Info("tables and pictures: " + page.string());
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kEvalCommand = {"eval",
                                     "Measures a result against its photos and a known truth",
                                     "RUN",
                                     Prepare<Options, Declare, Run>,
                                     kResult};

}  // namespace pathfit::app::eval_command
