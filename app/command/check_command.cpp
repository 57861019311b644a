#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <variant>

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

namespace pathfit::app::check_command {
namespace {

namespace fs = std::filesystem;

// A fit that takes longer, and with photos half as large no more than a share of that, is told so.
constexpr double kLongFit_s = 600.0;
constexpr double kWorthHalving = 0.7;

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

bool HasFittedPhotos(const Experiment& experiment) {
  return !std::ranges::all_of(experiment.observations.views,
                              [](const optim::View& view) { return view.validation; });
}

/// Numbers that a stage frees in the scene that the fit begins with.
std::int64_t NumScalars(const Experiment& experiment, std::size_t stage_index) {
  const optim::StageSpec& stage = experiment.fit.stages[stage_index];
  renderer::ParameterLayout layout(experiment.scene);
  for (const int index : stage.free) {
    const optim::UnknownSpec& unknown = experiment.fit.unknowns[static_cast<std::size_t>(index)];
    if (optim::IsReplaced(experiment.scene, unknown, experiment.fit.unknowns)) continue;
    layout.Add(unknown.kind, unknown.object);
  }
  return layout.NumScalars();
}

/// What uses a texture, in words: "roughness of bronze, light of lamp".
std::string TextureRoles(const renderer::Scene& scene, int texture) {
  std::string text;
  const auto add = [&](int used, const char* role, const std::string& name) {
    if (used == texture) text += (text.empty() ? "" : ", ") + std::string(role) + " of " + name;
  };
  for (const renderer::Material& material : scene.materials) {
    add(material.base_color_texture, "base colour", material.name);
    add(material.roughness_texture, "roughness", material.name);
    add(material.metallic_texture, "metallic", material.name);
    add(material.normal_texture, "normals", material.name);
  }
  for (const renderer::Emitter& emitter : scene.emitters) {
    if (const auto* area = std::get_if<renderer::AreaEmitter>(&emitter.light)) {
      add(area->texture, "light", emitter.name);
    } else if (const auto* projector = std::get_if<renderer::ProjectorEmitter>(&emitter.light)) {
      add(projector->texture, "light", emitter.name);
    }
  }
  return text.empty() ? "not used" : text;
}

/// All but what takes long to find.
void PrintStart(const Experiment& experiment, const StartCheck& start) {
  for (const std::string& text : experiment.assumptions) fmt::print("{}\n", text);
  for (const auto& mesh : experiment.scene.meshes) {
    fmt::print("Mesh {}: {} vertices, {} triangles.\n",
               mesh.name,
               mesh.mesh.positions.size(),
               mesh.mesh.triangles.size());
  }
  for (std::size_t i = 0; i < experiment.scene.textures.size(); ++i) {
    const renderer::Texture& texture = experiment.scene.textures[i];
    fmt::print("Texture {}: {} x {}, {}: {}.\n",
               texture.name,
               texture.width,
               texture.height,
               texture.scalar ? "numbers" : "colours",
               TextureRoles(experiment.scene, static_cast<int>(i)));
  }
  for (const auto& sensor : experiment.scene.sensors) {
    if (experiment.observations.views.empty()) {
      fmt::print("Sensor {}: {} x {} pixels.\n", sensor.name, sensor.width, sensor.height);
    }
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

void PrintStage(const Experiment& experiment,
                std::size_t index,
                const std::optional<optim::StageMemory>& memory) {
  const optim::StageSpec& stage = experiment.fit.stages[index];
  const auto scalars =
      memory ? static_cast<std::int64_t>(memory->num_scalars) : NumScalars(experiment, index);
  const auto at_start = memory ? static_cast<std::int64_t>(memory->num_scalars_at_start) : scalars;
  fmt::print("Stage {}: {} unknown numbers{}, images at {:g} of their size, up to {} rounds.\n",
             stage.name,
             scalars,
             scalars == at_start
                 ? ""
                 : fmt::format(" once its meshes and textures are as fine as those images ({} as "
                               "they come)",
                               at_start),
             stage.image_scale,
             stage.max_rounds);
  if (!memory) return;
  fmt::print("Memory of stage {}: about {:.0f} MB, solved by {}:",
             stage.name,
             optim::TotalBytes(memory->items) / 1e6,
             optim::LinearSolverName(memory->solver));
  for (const optim::MemoryItem& item : memory->items) {
    fmt::print(
        "{} {} {:.0f} MB", &item == &memory->items.front() ? "" : ",", item.what, item.bytes / 1e6);
  }
  fmt::print(".\nTime of stage {}: likely {}, at most {}; {} for its first round.\n",
             stage.name,
             DurationText(memory->times.likely_s),
             DurationText(memory->times.most_s),
             DurationText(memory->times.first_round_s));
}

void PrintTotal(const Experiment& experiment, const std::vector<optim::StageMemory>& memory) {
  if (memory.empty()) return;
  double likely_s = 0.0, most_s = 0.0, half_size_s = 0.0;
  for (const optim::StageMemory& stage : memory) {
    likely_s += stage.times.likely_s;
    most_s += stage.times.most_s;
    half_size_s += stage.likely_half_size_s;
  }
  fmt::print("Time of the fit: likely {}, at most {} on this machine, as busy as it is now.\n",
             DurationText(likely_s),
             DurationText(most_s));
  if (likely_s < kLongFit_s || half_size_s > kWorthHalving * likely_s) return;
  int longest = 0;
  for (const optim::View& view : experiment.observations.views) {
    longest = std::max({longest, view.photo.width(), view.photo.height()});
  }
  fmt::print("With photos half as large (input.max_size_px: {}): likely {}.\n",
             longest / 2,
             DurationText(half_size_s));
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
                              {"unknowns", NumScalars(experiment, i)},
                              {"unknowns_at_start", NumScalars(experiment, i)},
                              {"image_scale", stage.image_scale},
                              {"max_rounds", stage.max_rounds}});
  }
  for (std::size_t i = 0; i < memory.size(); ++i) {
    json["stages"][i]["unknowns"] = static_cast<std::int64_t>(memory[i].num_scalars);
    json["stages"][i]["unknowns_at_start"] =
        static_cast<std::int64_t>(memory[i].num_scalars_at_start);
    json["stages"][i]["memory_bytes"] = optim::TotalBytes(memory[i].items);
    json["stages"][i]["jacobian_bytes"] = memory[i].jacobian_bytes;
    json["stages"][i]["first_round_s"] = memory[i].times.first_round_s;
    json["stages"][i]["likely_s"] = memory[i].times.likely_s;
    json["stages"][i]["likely_half_size_s"] = memory[i].likely_half_size_s;
    json["stages"][i]["most_s"] = memory[i].times.most_s;
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
     "Maps of name, unknowns (with meshes as fine as its photos), unknowns_at_start, image_scale, "
     "max_rounds; with photos memory_bytes, jacobian_bytes, linear_solver, first_round_s, likely_s "
     "(of as many rounds as are usual), likely_half_size_s (with photos half as wide and high) and "
     "most_s (if all are needed)"},
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
  for (const std::string& warning : experiment.warnings) context.log.Warn(warning);
  for (const std::string& warning : start.warnings) context.log.Warn(warning);
  const bool speaks = !context.line.json;
  if (speaks) PrintStart(experiment, start);
  std::vector<optim::StageMemory> memory;
  Json result, page;
  const auto write_page = [&] {
    result = ResultOf(experiment, start, memory);
    page = nullptr;
    if (!start.views.empty()) {
      page = WritePage(context, own.output, config, experiment, start, result);
    }
    result["page"] = page;
  };
  write_page();
  // What a look at a few photos tells takes longer: it comes as it is found.
  const bool forecasts = HasFittedPhotos(experiment);
  const optim::MemoryItem loaded = optim::LoadedMemory();
  for (std::size_t i = 0; i < experiment.fit.stages.size(); ++i) {
    std::fflush(stdout);
    std::optional<optim::StageMemory> found;
    if (forecasts) {
      found = optim::ForecastStage(experiment.scene,
                                   experiment.observations,
                                   experiment.fit,
                                   static_cast<int>(i),
                                   loaded,
                                   optim::ForecastParts::kMemoryAndTimes);
    }
    if (speaks) PrintStage(experiment, i, found);
    if (!found) continue;
    std::fflush(stdout);
    optim::RequireMemory(*found, experiment.fit.stages[i].name, experiment.fit.max_memory_bytes);
    memory.push_back(std::move(*found));
  }
  if (page.is_null()) {
    result = ResultOf(experiment, start, memory);
    result["page"] = nullptr;
  } else if (!memory.empty()) {
    write_page();
  }
  if (speaks) {
    PrintTotal(experiment, memory);
    if (!page.is_null()) fmt::print("The start over every photo: {}\n", page.get<std::string>());
  } else {
    PrintResult(context, result);
  }
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kCheckCommand = {"check",
                                      "Checks a config and its input files; fits nothing",
                                      "CONFIG",
                                      Prepare<Options, Declare, Run>,
                                      kResult};

}  // namespace pathfit::app::check_command
