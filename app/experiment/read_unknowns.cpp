#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "app/config/map_reader.h"
#include "app/config/nearest_name.h"
#include "app/experiment/experiment.h"
#include "app/experiment/parameter_names.h"

namespace pathfit::app {
namespace {

using renderer::ParameterKind;
using renderer::ParameterTraits;

/// Reads the settings of one unknown, of which `traits` says what fits it.
class UnknownReader {
 public:
  UnknownReader(const UnknownConfig& config,
                const ParameterTraits& traits,
                std::vector<Problem>& problems)
      : traits_(traits),
        path_("unknowns." + config.name),
        node_(&config.settings),
        map_(&config.settings),
        problems_(problems) {}

  void Read(optim::UnknownSpec& unknown) const {
    ReadBounds(unknown);
    ReadTransform(unknown);
    ReadParametrisation(unknown);
    ReadPriors(unknown);
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
    const bool log = transform == nullptr ? traits_.log : transform->text == "log";
    unknown.parameterization =
        log ? optim::Parameterization::kLog : optim::Parameterization::kIdentity;
    if (transform != nullptr && log && (!traits_.bounded || traits_.smallest < 0.0)) {
      Report(transform->place, ".transform", fmt::format("log does not fit {}", traits_.property));
    }
  }

  void ReadParametrisation(optim::UnknownSpec& unknown) const {
    const YamlNode* node = node_->Find("parametrisation");
    if (node == nullptr) return;
    map_.Map("parametrisation").Map("large_steps").Get("lambda", unknown.large_steps_lambda);
    if (traits_.kind != ParameterKind::kVertexPositions) {
      Report(node->place,
             ".parametrisation",
             fmt::format("only vertices have one, not {}", traits_.property));
    }
  }

  void ReadPriors(optim::UnknownSpec& unknown) const {
    const YamlNode* priors = node_->Find("priors");
    if (priors == nullptr) return;
    std::vector<std::string> given;
    for (std::size_t i = 0; i < priors->items.size(); ++i) {
      const std::string key = fmt::format(".priors[{}]", i);
      for (const YamlEntry& entry : priors->items[i].entries) {
        if (std::find(given.begin(), given.end(), entry.key) != given.end()) {
          Report(entry.key_place, key, "prior '" + entry.key + "' is given twice");
          continue;
        }
        given.push_back(entry.key);
        ReadPrior(entry, key, unknown);
      }
    }
  }

  void ReadPrior(const YamlEntry& entry,
                 const std::string& key,
                 optim::UnknownSpec& unknown) const {
    const std::vector<std::string> fitting(traits_.priors.begin(), traits_.priors.end());
    if (std::find(fitting.begin(), fitting.end(), entry.key) == fitting.end()) {
      Report(entry.key_place,
             key,
             fmt::format("prior '{}' does not fit {} (allowed: {})",
                         entry.key,
                         traits_.property,
                         fitting.empty() ? "none" : JoinNames(fitting)));
      return;
    }
    const MapReader prior(&entry.value);
    if (entry.key == "laplacian") {
      prior.Get("weight", unknown.laplacian_weight);
    } else if (entry.key == "smooth") {
      prior.Get("weight", unknown.smooth_weight);
    } else if (entry.key == "neutral") {
      prior.Get("weight", unknown.neutral_weight);
    } else {
      optim::GaussianPriorSpec& gaussian = unknown.gaussian.emplace();
      prior.Get("sigma", gaussian.sigma);
      const YamlNode* mean = prior.Find("mean");
      if (mean == nullptr || (mean->IsScalar() && mean->text == "start")) return;
      gaussian.mean = NumbersOf(*mean);
      const auto wanted = static_cast<std::size_t>(traits_.NumComponents());
      const std::size_t count = gaussian.mean.size();
      if (count > 1 && wanted == 1) {
        Report(
            mean->place, key + ".gaussian.mean", fmt::format("{} is one number", traits_.property));
      } else if (count > 1 && count != wanted) {
        Report(mean->place,
               key + ".gaussian.mean",
               fmt::format("{} has {} numbers, not {}", traits_.property, wanted, count));
      }
    }
  }

  const ParameterTraits& traits_;
  std::string path_;
  const YamlNode* node_;
  MapReader map_;
  std::vector<Problem>& problems_;
};

std::string ProblemOfExposure(const UnknownConfig& unknown,
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

}  // namespace

std::vector<optim::UnknownSpec> ReadUnknowns(const ExperimentConfig& config,
                                             const renderer::Scene& scene) {
  std::vector<optim::UnknownSpec> unknowns;
  std::vector<Problem> problems;
  for (const UnknownConfig& item : config.unknowns) {
    ParameterName found = FindParameter(scene, item.name);
    if (found.problem.empty()) found.problem = ProblemOfExposure(item, found.parameter, config);
    if (!found.problem.empty()) {
      problems.push_back({item.place, "unknowns", found.problem});
      continue;
    }
    optim::UnknownSpec& unknown = unknowns.emplace_back();
    unknown.name = item.name;
    unknown.kind = found.parameter.kind;
    unknown.object = found.parameter.object;
    unknown.hold = item.hold;
    UnknownReader(
        item, renderer::TraitsOf(unknown.kind, scene, std::max(0, unknown.object)), problems)
        .Read(unknown);
  }
  if (!problems.empty()) throw ConfigError(config.source, problems);
  return unknowns;
}

}  // namespace pathfit::app
