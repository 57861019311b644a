#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/config/experiment_config.h"
#include "app/experiment/experiment.h"
#include "app/experiment/start_check.h"
#include "app/output/fields.h"
#include "optim/parameter/promotion.h"
#include "optim/round/memory_forecast.h"
#include "renderer/core/parallel.h"
#include "renderer/scene/parameter_layout.h"

namespace pathfit::app {
namespace {

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
    json["stages"][i]["linear_solver"] = optim::LinearSolverName(memory[i].solver);
  }
  for (const Overlap& overlap : OverlapsOf(start)) json["initial_iou"][overlap.name] = overlap.iou;
  for (const std::string& text : start.warnings) json["warnings"].push_back(text);
  return json;
}

constexpr ResultKey kResult[] = {
    {"assumptions", "list", "What was taken for granted, in words"},
    {"warnings", "list", "In words"},
    {"views", "whole", "Number of photos with a camera"},
    {"meshes", "list", "Maps of name, vertices and triangles"},
    {"stages",
     "list",
     "Maps of name, unknowns, image_scale, max_rounds; with photos memory_bytes and linear_solver"},
    {"initial_iou", "map", "By photo with a mask: overlap of the start's silhouette with it"}};

void Declare(OptionList& options, CommandLine& /*line*/) {
  options.Set();
  options.Threads();
  options.MaxMemory();
}

ExitStatus Run(CommandContext& context) {
  const ExperimentConfig config = LoadExperimentConfig(context.line.target, context.line.overrides);
  const renderer::ThreadLimit limit(NumThreads(context.line, config.threads));
  const Experiment experiment = BuildExperiment(config);
  const StartCheck start = CheckStart(config, experiment);
  const std::vector<optim::StageMemory> memory = ForecastStages(experiment);
  if (context.line.json) {
    PrintResult(context, ResultOf(experiment, start, memory));
  } else {
    PrintSummary(experiment, start, memory);
  }
  for (const std::string& warning : experiment.warnings) context.log.Warn(warning);
  for (const std::string& warning : start.warnings) context.log.Warn(warning);
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kCheckCommand = {
    "check", "Checks a config and its input files; fits nothing", "CONFIG", Declare, Run, kResult};

}  // namespace pathfit::app
