#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/config/experiment_config.h"
#include "app/experiment/experiment.h"
#include "app/experiment/start_check.h"
#include "app/output/check_page.h"
#include "app/output/fields.h"
#include "app/output/progress.h"
#include "app/output/report.h"
#include "optim/parameter/promotion.h"
#include "optim/round/memory_forecast.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/io/atomic_file.h"
#include "renderer/scene/parameter_layout.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;

/// Of all photos with a mask, the worst first.
struct Overlap {
  std::string name;
  double iou = 0.0;
};
std::vector<Overlap> OverlapsOf(const StartCheck& start) {
  std::vector<Overlap> overlaps;
  for (const ViewStart& view : start.views) {
    if (!std::isnan(view.iou)) overlaps.push_back({view.name, view.iou});
  }
  std::ranges::sort(overlaps, [](const auto& a, const auto& b) { return a.iou < b.iou; });
  return overlaps;
}

/// By stage; none without photos.
std::vector<optim::StageMemory> ForecastStages(const Experiment& experiment) {
  const auto& views = experiment.observations.views;
  if (std::ranges::all_of(views, [](const optim::View& view) { return view.validation; })) {
    return {};
  }
  return optim::ForecastStages(experiment.scene, experiment.observations, experiment.fit);
}

/// Of what takes another form in the stage, the forecast knows the number.
std::int64_t NumScalars(const Experiment& experiment,
                        const std::vector<optim::StageMemory>& memory,
                        std::size_t stage_index) {
  const optim::StageSpec& stage = experiment.fit.stages[stage_index];
  renderer::ParameterLayout layout(experiment.scene);
  for (const int index : stage.free) {
    const optim::UnknownSpec& unknown = experiment.fit.unknowns[static_cast<std::size_t>(index)];
    if (optim::IsReplaced(experiment.scene, unknown, experiment.fit.unknowns)) {
      if (!memory.empty()) return static_cast<std::int64_t>(memory[stage_index].num_scalars);
      continue;
    }
    layout.Add(unknown.kind, unknown.object);
  }
  return layout.NumScalars();
}

void PrintSummary(const Experiment& experiment,
                  const StartCheck& start,
                  const std::vector<optim::StageMemory>& memory) {
  for (const std::string& text : experiment.assumptions) fmt::print("{}\n", text);
  for (const auto& mesh : experiment.scene.meshes) {
    fmt::print("Mesh {}: {} vertices, {} triangles.\n",
               mesh.name,
               mesh.mesh.positions.size(),
               mesh.mesh.triangles.size());
  }
  for (const auto& sensor : experiment.scene.sensors) {
    if (experiment.observations.views.empty()) {
      fmt::print("Sensor {}: {} x {} pixels.\n", sensor.name, sensor.width, sensor.height);
    }
  }
  for (std::size_t i = 0; i < experiment.fit.stages.size(); ++i) {
    const optim::StageSpec& stage = experiment.fit.stages[i];
    fmt::print("Stage {}: {} unknown numbers, images at {:g} of their size, up to {} rounds.\n",
               stage.name,
               NumScalars(experiment, memory, i),
               stage.image_scale,
               stage.max_rounds);
  }
  for (std::size_t i = 0; i < memory.size(); ++i) {
    fmt::print("Memory of stage {}: about {:.0f} MB with {:.0f} unknown numbers, solved by {}:",
               experiment.fit.stages[i].name,
               optim::TotalBytes(memory[i].items) / 1e6,
               memory[i].num_scalars,
               optim::LinearSolverName(memory[i].solver));
    for (const optim::MemoryItem& item : memory[i].items) {
      fmt::print("{} {} {:.0f} MB",
                 &item == &memory[i].items.front() ? "" : ",",
                 item.what,
                 item.bytes / 1e6);
    }
    fmt::print(".\n");
  }
  double total_s = 0.0;
  for (std::size_t i = 0; i < memory.size(); ++i) {
    fmt::print("Time of stage {}: about {} for its first round, {} if it needs all its rounds.\n",
               experiment.fit.stages[i].name,
               DurationText(memory[i].first_round_s),
               DurationText(memory[i].most_s));
    total_s += memory[i].most_s;
  }
  if (!memory.empty()) {
    fmt::print("Time of the fit: at most about {} on this machine, as busy as it is now.\n",
               DurationText(total_s));
  }
  const std::vector<Overlap> overlaps = OverlapsOf(start);
  if (overlaps.empty() && !experiment.observations.views.empty()) {
    fmt::print(
        "Silhouette of the initial model against the masks: - (there are no silhouettes).\n");
  } else if (!overlaps.empty()) {
    fmt::print(
        "Silhouette of the initial model against the masks: median IoU {:.3f}, worst {:.3f} "
        "({}).\n",
        overlaps[overlaps.size() / 2].iou,
        overlaps.front().iou,
        overlaps.front().name);
  }
}

Json ResultOf(const Experiment& experiment,
              const StartCheck& start,
              const std::vector<optim::StageMemory>& memory) {
  Json json;
  json["assumptions"] = experiment.assumptions;
  json["warnings"] = experiment.warnings;
  json["views"] = experiment.observations.views.size();
  for (const char* list : {"meshes", "stages"}) json[list] = Json::array();
  json["initial_iou"] = Json::object();
  for (const auto& mesh : experiment.scene.meshes) {
    json["meshes"].push_back({{"name", mesh.name},
                              {"vertices", mesh.mesh.positions.size()},
                              {"triangles", mesh.mesh.triangles.size()}});
  }
  for (std::size_t i = 0; i < experiment.fit.stages.size(); ++i) {
    const optim::StageSpec& stage = experiment.fit.stages[i];
    json["stages"].push_back({{"name", stage.name},
                              {"unknowns", NumScalars(experiment, memory, i)},
                              {"image_scale", stage.image_scale},
                              {"max_rounds", stage.max_rounds}});
  }
  for (std::size_t i = 0; i < memory.size(); ++i) {
    json["stages"][i]["memory_bytes"] = optim::TotalBytes(memory[i].items);
    json["stages"][i]["jacobian_bytes"] = memory[i].jacobian_bytes;
    json["stages"][i]["first_round_s"] = memory[i].first_round_s;
    json["stages"][i]["most_s"] = memory[i].most_s;
    json["stages"][i]["linear_solver"] = optim::LinearSolverName(memory[i].solver);
  }
  for (const Overlap& overlap : OverlapsOf(start)) json["initial_iou"][overlap.name] = overlap.iou;
  for (const std::string& text : start.warnings) json["warnings"].push_back(text);
  return json;
}

/// Its path; null if the folder that nobody chose takes no file.
Json WritePage(CommandContext& context,
               const fs::path& output,
               const ExperimentConfig& config,
               const Experiment& experiment,
               const StartCheck& start,
               const Json& summary) {
  const bool chosen = !output.empty();
  const fs::path page = fs::absolute(chosen ? output : "check.html");
  const std::string text = ReportPage(CheckJson(config, experiment, start, summary));
  try {
    renderer::WriteFileAtomically(page, text);
  } catch (const renderer::IoError& error) {
    if (chosen) throw;
    context.log.Warn(std::string("no page is written: ") + error.what() + "; -o says another file");
    return nullptr;
  }
  return page.string();
}

constexpr ResultKey kResult[] = {
    {"assumptions", "list", "What was taken for granted, in words"},
    {"warnings", "list", "In words"},
    {"views", "whole", "Number of photos with a camera"},
    {"meshes", "list", "Maps of name, vertices and triangles"},
    {"stages",
     "list",
     "Maps of name, unknowns, image_scale, max_rounds; with photos memory_bytes, jacobian_bytes, "
     "linear_solver, first_round_s and most_s (if all rounds are needed)"},
    {"initial_iou", "map", "By photo with a mask: overlap of the start's silhouette with it"},
    {"page", "text or null", "The page that was written; null without photos"}};

struct Options {
  fs::path output;  ///< empty: check.html here
};

void Declare(OptionList& options, Options& own) {
  options.Set();
  options.Threads();
  options.MaxMemory();
  options.Path("-o,--output",
               "FILE",
               "Page to write, the start drawn over every photo; else check.html here",
               own.output);
}

ExitStatus Run(CommandContext& context, const Options& own) {
  const ExperimentConfig config = LoadExperimentConfig(context.line.target, context.line.overrides);
  const renderer::ThreadLimit limit(NumThreads(context.line, config.threads));
  const Experiment experiment = BuildExperiment(config);
  const StartCheck start = CheckStart(config, experiment);
  const std::vector<optim::StageMemory> memory = ForecastStages(experiment);
  Json result = ResultOf(experiment, start, memory);
  Json& page = result["page"] = nullptr;
  if (!start.views.empty())
    page = WritePage(context, own.output, config, experiment, start, result);
  if (context.line.json) {
    PrintResult(context, result);
  } else {
    PrintSummary(experiment, start, memory);
    if (!page.is_null()) fmt::print("The start over every photo: {}\n", page.get<std::string>());
  }
  for (const std::string& warning : experiment.warnings) context.log.Warn(warning);
  for (const std::string& warning : start.warnings) context.log.Warn(warning);
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kCheckCommand = {"check",
                                      "Checks a config and its input files; fits nothing",
                                      "CONFIG",
                                      Prepare<Options, Declare, Run>,
                                      kResult};

}  // namespace pathfit::app
