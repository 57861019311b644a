#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "app/config/nearest_name.h"
#include "app/config/resolved_yaml.h"
#include "app/config/scalar.h"
#include "app/config/schema_builders.h"
#include "app/experiment/experiment.h"
#include "app/experiment/parameter_names.h"

namespace pathfit::app {
namespace {

double NumberOf(const YamlNode& node) { return ParseNumber(node, true).value.value_or(0.0); }

using renderer::ParameterKind;
using renderer::ParameterTraits;

/// Completes the settings of one unknown, of which `traits` says what fits it.
class UnknownReader {
 public:
  UnknownReader(const YamlEntry& entry,
                const ParameterTraits& traits,
                std::vector<Problem>& problems)
      : traits_(traits), path_("unknowns." + entry.key), node_(&entry.value), problems_(problems) {}

  void Read(optim::UnknownSpec& unknown) const {
    ReadBounds(unknown);
    ReadTransform(unknown);
    CheckParametrisation();
    CheckPriors(unknown);
  }

 private:
  void Report(const Place& place, const std::string& key, std::string text) const {
    problems_.push_back({place, path_ + key, std::move(text)});
  }

  void ReadBounds(optim::UnknownSpec& unknown) const {
    const YamlNode* bounds = node_->Find("bounds");
    if (!traits_.bounded) {
      if (bounds != nullptr) {
        Report(bounds->place,
               ".bounds",
               fmt::format(
                   "bounds of {} are not supported{}", traits_.property, traits_.bounds_advice));
      }
      return;
    }
    unknown.lower = traits_.lower;
    unknown.upper = traits_.upper;
    if (bounds == nullptr) return;
    unknown.lower = NumberOf(bounds->items[0]);
    unknown.upper = NumberOf(bounds->items[1]);
    if (unknown.lower > unknown.upper) {
      Report(bounds->place,
             ".bounds",
             fmt::format("lower bound {} is above upper bound {}", unknown.lower, unknown.upper));
      return;
    }
    if (unknown.lower == unknown.upper) {
      Report(bounds->place,
             ".bounds",
             fmt::format("both bounds are {}; to keep a value, write hold: true", unknown.lower));
      return;
    }
    for (const YamlNode& item : bounds->items) {
      const double value = NumberOf(item);
      if (value >= traits_.smallest && value <= traits_.largest) continue;
      const std::string allowed =
          std::isinf(traits_.largest)
              ? fmt::format("at least {}", traits_.smallest)
              : fmt::format("from {} to {}", traits_.smallest, traits_.largest);
      Report(item.place,
             ".bounds",
             fmt::format("{} is out of range (allowed: {})", item.text, allowed));
    }
  }

  void ReadTransform(optim::UnknownSpec& unknown) const {
    const YamlNode* transform = node_->Find("transform");
    if (transform == nullptr && traits_.log) {
      unknown.parameterization = optim::Parameterization::kLog;
    }
    const bool log = unknown.parameterization == optim::Parameterization::kLog;
    if (transform != nullptr && log && (!traits_.bounded || traits_.smallest < 0.0)) {
      Report(transform->place, ".transform", fmt::format("log does not fit {}", traits_.property));
    }
  }

  void CheckParametrisation() const {
    for (const std::string key : {"parametrisation", "mesh"}) {
      const YamlNode* node = node_->Find(key);
      if (node != nullptr && traits_.kind != ParameterKind::kVertexPositions) {
        Report(node->place,
               "." + key,
               fmt::format("only vertices have one, not {}", traits_.property));
      }
    }
  }

  void CheckPriors(const optim::UnknownSpec& unknown) const {
    const YamlNode* priors = node_->Find("priors");
    if (priors == nullptr) return;
    std::vector<std::string> given;
    for (std::size_t i = 0; i < priors->items.size(); ++i) {
      const std::string key = fmt::format(".priors[{}]", i);
      for (const YamlEntry& entry : priors->items[i].entries) {
        if (std::ranges::find(given, entry.key) != given.end()) {
          Report(entry.key_place, key, "prior '" + entry.key + "' is given twice");
          continue;
        }
        given.push_back(entry.key);
        CheckPrior(entry, key, unknown);
      }
    }
  }

  void CheckPrior(const YamlEntry& entry,
                  const std::string& key,
                  const optim::UnknownSpec& unknown) const {
    const std::vector<std::string> fitting(traits_.priors.begin(), traits_.priors.end());
    if (std::ranges::find(fitting, entry.key) == fitting.end()) {
      Report(entry.key_place,
             key,
             fmt::format("prior '{}' does not fit {} (allowed: {})",
                         entry.key,
                         traits_.property,
                         fitting.empty() ? "none" : JoinNames(fitting)));
      return;
    }
    if (entry.key != "gaussian" || !unknown.gaussian) return;
    const auto wanted = static_cast<std::size_t>(traits_.NumComponents());
    const std::size_t count = unknown.gaussian->mean.size();
    if (count <= 1 || count == wanted) return;
    Report(entry.value.Find("mean")->place,
           key + ".gaussian.mean",
           wanted == 1 ? fmt::format("{} is one number", traits_.property)
                       : fmt::format("{} has {} numbers, not {}", traits_.property, wanted, count));
  }

  const ParameterTraits& traits_;
  std::string path_;
  const YamlNode* node_;
  std::vector<Problem>& problems_;
};

std::string ProblemOfExposure(const optim::UnknownSpec& unknown,
                              const renderer::ParameterRef& parameter,
                              const ExperimentConfig& config) {
  if (parameter.kind != ParameterKind::kExposure) return {};
  if (unknown.name != "exposure") {
    return "'" + unknown.name + "' is not known here; write exposure, for all sensors";
  }
  return config.input && !config.input->exposure_gain
             ? "'exposure' needs input.exposure.model: gain"
             : "";
}

/// What vertices do that say nothing: UVs of a file are its maker's work.
optim::MeshDetail DefaultDetail(const ExperimentConfig& config, const renderer::SceneMesh& mesh) {
  const bool from_file = std::any_of(
      config.geometry.begin(), config.geometry.end(), [&](const GeometryConfig& geometry) {
        if (!std::holds_alternative<FileGeometry>(geometry.geometry)) return false;
        return geometry.name == mesh.name ||
               (IsGltf(geometry) && mesh.name.starts_with(geometry.name + "-")) ||
               std::any_of(geometry.group_materials.begin(),
                           geometry.group_materials.end(),
                           [&](const auto& group) {
                             return GroupMeshName(geometry.name, group.first) == mesh.name;
                           });
      });
  return from_file && !mesh.mesh.uvs.empty() ? optim::MeshDetail::kKeep
                                             : optim::MeshDetail::kLevels;
}

void SetDefaults(const YamlNode& node,
                 const ExperimentConfig& config,
                 const renderer::Scene& scene,
                 optim::UnknownSpec& vertices) {
  if (node.Find("mesh") == nullptr) {
    vertices.mesh_detail =
        DefaultDetail(config, scene.meshes[static_cast<std::size_t>(vertices.object)]);
  }
  if (node.Find("parametrisation") == nullptr) {
    vertices.large_steps_lambda = optim::kDefaultLargeSteps;
  }
  if (node.Find("priors") == nullptr) vertices.laplacian_weight = optim::kDefaultLaplacian;
}

// Of all sensors, those of the first.
const ParameterTraits& TraitsOf(const renderer::ParameterRef& parameter,
                                const renderer::Scene& scene) {
  return renderer::TraitsOf(parameter.kind, scene, std::max(0, parameter.object));
}

}  // namespace

std::vector<optim::UnknownSpec> ReadUnknowns(const ExperimentConfig& config,
                                             const renderer::Scene& scene) {
  std::vector<optim::UnknownSpec> unknowns;
  std::vector<Problem> problems;
  for (std::size_t i = 0; i < config.fit.unknowns.size(); ++i) {
    const optim::UnknownSpec& item = config.fit.unknowns[i];
    const YamlEntry& entry = config.resolved.Find("unknowns")->entries[i];
    ParameterName found = FindParameter(scene, item.name);
    if (found.problem.empty()) found.problem = ProblemOfExposure(item, found.parameter, config);
    if (!found.problem.empty()) {
      problems.push_back({entry.key_place, "unknowns", found.problem});
      continue;
    }
    optim::UnknownSpec& unknown = unknowns.emplace_back(item);
    unknown.kind = found.parameter.kind;
    unknown.object = found.parameter.object;
    UnknownReader(entry, TraitsOf(found.parameter, scene), problems).Read(unknown);
    if (unknown.kind == ParameterKind::kVertexPositions)
      SetDefaults(entry.value, config, scene, unknown);
  }
  if (!problems.empty()) throw ConfigError(config.source, problems);
  return unknowns;
}

std::string ResolvedYaml(const ExperimentConfig& config, const renderer::Scene& scene) {
  YamlNode root = config.resolved;
  YamlNode none;
  YamlNode* unknowns = root.Find("unknowns");
  for (YamlEntry& entry : (unknowns == nullptr ? none : *unknowns).entries) {
    const ParameterTraits& traits = TraitsOf(FindParameter(scene, entry.key).parameter, scene);
    const auto fill = [&](const char* key, const std::string& yaml) {
      if (entry.value.Find(key) == nullptr) SetDefault(entry.value, key, yaml);
    };
    if (traits.bounded) {
      fill("bounds", binding::Write(std::array{traits.lower, traits.upper}));
      fill("transform", traits.log ? "log" : "identity");
    }
    if (traits.kind == ParameterKind::kVertexPositions) {
      fill("parametrisation",
           fmt::format("{{large_steps: {{lambda: {}}}}}", optim::kDefaultLargeSteps));
      fill("priors", fmt::format("[{{laplacian: {{weight: {}}}}}]", optim::kDefaultLaplacian));
      const int mesh = FindParameter(scene, entry.key).parameter.object;
      const bool keeps = DefaultDetail(config, scene.meshes[static_cast<std::size_t>(mesh)]) ==
                         optim::MeshDetail::kKeep;
      fill("mesh", keeps ? "keep" : "levels");
    }
    fill("priors", "[]");
  }
  return WriteResolvedYaml(root, config.source);
}

}  // namespace pathfit::app
