#include <algorithm>

#include <fmt/format.h>

#include "app/config/map_reader.h"
#include "app/config/nearest_name.h"
#include "app/config/read_config.h"
#include "app/config/scalar.h"

namespace pathfit::app {
namespace {

bool Contains(const std::vector<std::string>& list, const std::string& text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

void ReadFree(const YamlNode& node,
              const std::string& path,
              ConfigReading& reading,
              StageConfig& stage) {
  std::vector<std::string> known;
  for (const UnknownConfig& unknown : reading.config.unknowns) known.push_back(unknown.name);
  if (node.IsScalar()) {
    for (const UnknownConfig& unknown : reading.config.unknowns) {
      if (!unknown.hold) stage.free.push_back(unknown.name);
    }
    if (stage.free.empty()) {
      reading.Report(node.place,
                     path,
                     known.empty() ? "there are no unknowns to free" : "every unknown is held");
    }
    return;
  }
  for (const YamlNode& item : node.items) {
    const auto found = std::find(known.begin(), known.end(), item.text);
    if (found == known.end()) {
      reading.Report(item.place,
                     path,
                     "no unknown is called '" + item.text + "'" + NameHint(item.text, known));
    } else if (reading.config.unknowns[static_cast<std::size_t>(found - known.begin())].hold) {
      reading.Report(item.place, path, "'" + item.text + "' is held (hold: true)");
    } else if (Contains(stage.free, item.text)) {
      reading.Report(item.place, path, "'" + item.text + "' is given twice");
    } else {
      stage.free.push_back(item.text);
    }
  }
}

StageConfig ReadStage(const YamlNode& node, const std::string& path, ConfigReading& reading) {
  const MapReader map(&node);
  StageConfig stage;
  map.Get("name", stage.name);
  if (const YamlNode* list = map.Find("free")) ReadFree(*list, path + ".free", reading, stage);
  map.Get("image_scale", stage.image_scale);
  map.Get("max_rounds", stage.max_rounds);
  map.Get("spp", stage.spp);
  map.Get("max_spp", stage.max_spp);
  map.Get("spp_growth", stage.spp_growth);
  map.Get("sppe", stage.sppe);
  map.Get("spp_direct", stage.spp_direct);
  map.Get("spp_indirect", stage.spp_indirect);
  map.Get("spp_pixel", stage.spp_pixel);
  map.Map("stop").Get("relative_cost", stage.stop_relative_cost);
  if (map.Has("spp") && map.Has("max_spp") && stage.spp > stage.max_spp) {
    const YamlNode* spp = map.Find("spp");
    const YamlNode* max_spp = map.Find("max_spp");
    const bool max_given = max_spp->place.source != Place::Source::kDefault;
    reading.Report(max_given ? max_spp->place : spp->place,
                   path + ".max_spp",
                   fmt::format("max_spp {} is below spp {}", stage.max_spp, stage.spp));
  }
  return stage;
}

void ReadRender(const MapReader& map, ConfigReading& reading) {
  RenderConfig& render = reading.config.render;
  map.Get("spp", render.spp);
  map.Get("sppe", render.sppe);
  map.Get("spp_direct", render.spp_direct);
  map.Get("spp_indirect", render.spp_indirect);
  map.Get("spp_pixel", render.spp_pixel);
  map.Get("max_bounces", render.max_bounces);
  map.Get("rr_depth", render.rr_depth);
  if (const YamlNode* list = map.Find("terms")) {
    std::vector<std::string> terms;
    for (const YamlNode& item : list->items) {
      if (Contains(terms, item.text)) {
        reading.Report(item.place, "render.terms", "'" + item.text + "' is given twice");
      }
      terms.push_back(item.text);
    }
    render.interior = Contains(terms, "interior");
    render.primary = Contains(terms, "primary");
    render.direct = Contains(terms, "direct");
    render.indirect = Contains(terms, "indirect");
    render.pixel = Contains(terms, "pixel");
  }
  render.material_form = map.TextOf("form") == "material";
  const std::string guiding = map.TextOf("guiding");
  render.guiding = guiding == "none"   ? RenderConfig::Guiding::kNone
                   : guiding == "grid" ? RenderConfig::Guiding::kGrid
                                       : RenderConfig::Guiding::kAdaptive;
  map.Get("guide_share", render.guide_share);
  map.Get("antithetic", render.antithetic);
}

}  // namespace

void ReadUnknowns(ConfigReading& reading) {
  const YamlNode* unknowns = reading.root.Find("unknowns");
  if (unknowns == nullptr) return;
  for (const YamlEntry& entry : unknowns->entries) {
    UnknownConfig unknown{entry.key, entry.key_place, false, entry.value};
    MapReader(&entry.value).Get("hold", unknown.hold);
    reading.config.unknowns.push_back(std::move(unknown));
  }
}

void ReadStages(ConfigReading& reading) {
  const YamlNode* stages = reading.root.Find("stages");
  if (stages == nullptr) return;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < stages->items.size(); ++i) {
    const YamlNode& node = stages->items[i];
    const std::string path = fmt::format("stages[{}]", i);
    reading.config.stages.push_back(ReadStage(node, path, reading));
    const YamlNode* name = node.Find("name");
    if (name == nullptr) continue;
    if (Contains(names, name->text)) {
      reading.Report(
          name->place, path + ".name", "another stage is called '" + name->text + "' already");
    }
    names.push_back(name->text);
  }
  if (!stages->items.empty() && !reading.has_input) {
    reading.Report(stages->place, "stages", "a fit needs photos; give input");
  }
}

void ReadSettings(ConfigReading& reading) {
  ExperimentConfig& config = reading.config;
  const MapReader root(&reading.root);
  ReadRender(root.Map("render"), reading);

  const MapReader loss = root.Map("loss");
  config.loss.relative = loss.TextOf("residual") == "relative";
  loss.Get("relative_floor", config.loss.relative_floor);
  loss.Map("silhouette").Get("weight", config.loss.silhouette_weight);

  const MapReader solver = root.Map("solver");
  solver.Get("linear_solver", config.solver.linear_solver);
  if (const YamlNode* memory = solver.Find("max_memory")) {
    config.solver.max_memory_bytes = ParseBytes(*memory).value.value_or(0.0);
  }
  solver.Get("threads", config.solver.threads);

  const MapReader output = root.Map("output");
  output.Get("directory", config.output.directory);
  output.Map("images").Get("every_stage", config.output.images_every_stage);
  output.Get("report", config.output.report);

  const MapReader gradcheck = root.Map("gradcheck");
  if (const YamlNode* params = gradcheck.Find("params")) {
    for (const YamlNode& item : params->items) config.gradcheck.params.push_back(item.text);
  }
  gradcheck.Get("step", config.gradcheck.step);
  gradcheck.Get("spp", config.gradcheck.spp);
  gradcheck.Get("replicates", config.gradcheck.replicates);
  gradcheck.Get("sigma", config.gradcheck.sigma);
}

}  // namespace pathfit::app
