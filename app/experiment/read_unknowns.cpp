#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "app/config/nearest_name.h"
#include "app/config/resolved_yaml.h"
#include "app/config/scalar.h"
#include "app/config/schema_builders.h"
#include "app/experiment/experiment.h"
#include "app/experiment/parameter_names.h"
#include "app/experiment/promotions.h"
#include "renderer/core/check.h"
#include "renderer/scene/texture_surface.h"

namespace pathfit::app {
namespace {

double NumberOf(const YamlNode& node) { return ParseNumber(node, true).value.value_or(0.0); }

using renderer::ParameterKind;
using renderer::ParameterTraits;

/// Completes the settings of one unknown, of which `traits` says what fits it.
class UnknownReader {
 public:
  /// `priors`: names of those that suit it.
  UnknownReader(const YamlEntry& entry,
                const ParameterTraits& traits,
                std::vector<std::string> priors,
                std::vector<Problem>& problems)
      : traits_(traits),
        fitting_(std::move(priors)),
        path_("unknowns." + entry.key),
        node_(&entry.value),
        problems_(problems) {}

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
    if (std::ranges::find(fitting_, entry.key) == fitting_.end()) {
      Report(entry.key_place,
             key,
             fmt::format("prior '{}' does not fit {} (allowed: {})",
                         entry.key,
                         traits_.property,
                         fitting_.empty() ? "none" : JoinNames(fitting_)));
      return;
    }
    if (entry.key == "log_smooth" && unknown.parameterization != optim::Parameterization::kLog) {
      Report(entry.key_place, key, "prior 'log_smooth' needs transform: log");
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
  std::vector<std::string> fitting_;
  std::string path_;
  const YamlNode* node_;
  std::vector<Problem>& problems_;
};

std::string ProblemOfExposure(const optim::UnknownSpec& unknown,
                              const renderer::ParameterRef& parameter,
                              const ExperimentConfig& config) {
  if (!optim::IsOfExposure(parameter.kind)) return {};
  const bool is_balance = parameter.kind == ParameterKind::kWhiteBalance;
  const std::string name = renderer::TraitsOf(parameter.kind).property;
  if (unknown.name != name) {
    return "'" + unknown.name + "' is not known here; write " + name + ", for all sensors";
  }
  if (!config.input) return "";
  const ExposureUnknown model = config.input->exposure_model;
  if (is_balance && model != ExposureUnknown::kGainRgb) {
    return "'white_balance' needs input.exposure.model: gain_rgb";
  }
  return model == ExposureUnknown::kNone ? "'exposure' needs input.exposure.model: gain" : "";
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
                 optim::UnknownSpec& unknown) {
  const bool has_priors = node.Find("priors") != nullptr;
  if (unknown.kind == ParameterKind::kEnvironmentTexels && !has_priors &&
      unknown.parameterization == optim::Parameterization::kLog) {
    unknown.log_smooth_weight = optim::kDefaultLogSmooth;
  }
  if (unknown.kind == ParameterKind::kVertexColors && !has_priors) {
    unknown.smooth_weight = optim::kDefaultColorSmooth;
  }
  if (unknown.kind != ParameterKind::kVertexPositions) return;
  if (node.Find("mesh") == nullptr) {
    unknown.mesh_detail =
        DefaultDetail(config, scene.meshes[static_cast<std::size_t>(unknown.object)]);
  }
  if (node.Find("parametrisation") == nullptr) {
    unknown.large_steps_lambda = optim::kDefaultLargeSteps;
  }
  if (!has_priors) unknown.laplacian_weight = optim::kDefaultLaplacian;
}

// Of all sensors, those of the first.
const ParameterTraits& TraitsOf(const renderer::ParameterRef& parameter,
                                const renderer::Scene& scene) {
  return renderer::TraitsOf(parameter.kind, scene, std::max(0, parameter.object));
}

std::vector<std::string> PriorsOf(const ParameterTraits& traits) {
  return {traits.priors.begin(), traits.priors.end()};
}

/// The traits of the numbers that stand for a property in one of its forms.
const ParameterTraits& TraitsOf(const PromotedUnknown& promoted,
                                SurfaceForm form,
                                const renderer::Scene& scene) {
  const ParameterKind property = promoted.promotion.property;
  if (form == SurfaceForm::kVertices) return renderer::TraitsOf(ParameterKind::kVertexColors);
  if (form == SurfaceForm::kConstant) {
    return renderer::TraitsOf(property, scene, promoted.promotion.material);
  }
  // Rows of texels have the bounds of what they stand for; the scene has no use of them yet.
  return renderer::TraitsOf(ParameterKind::kTextureTexels);
}

std::vector<std::string> PriorsOf(const PromotedUnknown& promoted, const renderer::Scene& scene) {
  std::vector<std::string> names = PriorsOf(renderer::TraitsOf(promoted.promotion.property));
  for (const SurfaceForm form : promoted.forms) {
    for (const std::string& name : PriorsOf(TraitsOf(promoted, form, scene))) {
      if (!Contains(names, name)) names.push_back(name);
    }
  }
  return names;
}

double DefaultVariation(const PromotedUnknown& promoted) {
  return promoted.promotion.property == ParameterKind::kRoughness
             ? optim::kDefaultRoughnessVariation
             : optim::kDefaultTexelVariation;
}

/// The unknowns of the program that one of the config is in each of its forms: indices into
/// `unknowns`, to which they are added; the first takes the place that it has there.
std::vector<std::vector<int>> AddForms(const PromotedUnknown& promoted,
                                       const renderer::Scene& scene,
                                       bool has_priors,
                                       std::vector<optim::UnknownSpec>& unknowns) {
  const optim::UnknownSpec common = unknowns[promoted.index];
  std::map<SurfaceForm, std::vector<int>> of_form;
  bool is_first = true;
  const auto add = [&](SurfaceForm form, ParameterKind kind, int object, const std::string& name) {
    const std::size_t index = is_first ? promoted.index : unknowns.size();
    if (!is_first) unknowns.push_back(common);
    is_first = false;
    optim::UnknownSpec& unknown = unknowns[index];
    unknown.kind = kind;
    unknown.object = object;
    unknown.name = name + "." + renderer::TraitsOf(kind).property;
    if (form != SurfaceForm::kConstant) unknown.promotion = promoted.promotion;
    if (form == SurfaceForm::kTexture && !has_priors) {
      unknown.total_variation_weight = DefaultVariation(promoted);
    }
    of_form[form].push_back(static_cast<int>(index));
  };
  std::vector<std::vector<int>> indices;
  const int material = promoted.promotion.material;
  for (const SurfaceForm form : promoted.forms) {
    if (of_form.contains(form)) {
      indices.push_back(of_form[form]);
      continue;
    }
    if (form == SurfaceForm::kConstant) {
      add(form,
          promoted.promotion.property,
          material,
          scene.materials[static_cast<std::size_t>(material)].name);
    } else if (form == SurfaceForm::kVertices) {
      for (const int mesh : renderer::MeshesOfMaterial(scene, material)) {
        add(form,
            ParameterKind::kVertexColors,
            mesh,
            scene.meshes[static_cast<std::size_t>(mesh)].name);
      }
    } else {
      const std::string name = PromotedTextureName(scene, promoted.promotion);
      const auto texture = std::ranges::find(scene.textures, name, &renderer::Texture::name);
      PATHFIT_CHECK(texture != scene.textures.end());  // AddPromotedTextures
      add(form,
          ParameterKind::kTextureTexels,
          static_cast<int>(texture - scene.textures.begin()),
          name);
    }
    indices.push_back(of_form[form]);
  }
  return indices;
}

/// What is promoted is given around a value: of the numbers at the start there are others later.
void CheckStartPrior(const YamlEntry& entry,
                     const PromotedUnknown& promoted,
                     const optim::UnknownSpec& unknown,
                     std::vector<Problem>& problems) {
  const bool changes = std::ranges::any_of(
      promoted.forms, [](SurfaceForm form) { return form != SurfaceForm::kConstant; });
  if (!changes || !unknown.gaussian || !unknown.gaussian->mean.empty()) return;
  problems.push_back({entry.value.Find("priors")->place,
                      "unknowns." + entry.key + ".priors",
                      "a gaussian prior around the start does not fit what becomes vertex colours "
                      "or a texture; give a mean"});
}

/// By sensor the first one that has the property in common with it; empty: none can have.
std::vector<int> SharingOf(const optim::UnknownSpec& unknown,
                           const ExperimentConfig& config,
                           const renderer::Scene& scene) {
  const ParameterTraits& traits = renderer::TraitsOf(unknown.kind);
  const bool stood_still = config.input && !config.input->sensor.empty();
  if (unknown.object >= 0 || optim::IsOfExposure(unknown.kind) ||
      !(traits.of_lens || stood_still)) {
    return {};
  }
  std::vector<int> first_of;
  for (const renderer::Camera& sensor : scene.sensors) {
    const auto first = std::ranges::find_if(scene.sensors, [&](const renderer::Camera& other) {
      return renderer::HaveSameLens(sensor, other);
    });
    first_of.push_back(static_cast<int>(first - scene.sensors.begin()));
  }
  return first_of;
}

void ReadSharing(const YamlEntry& entry,
                 const ParameterTraits& traits,
                 const ExperimentConfig& config,
                 const renderer::Scene& scene,
                 optim::UnknownSpec& unknown,
                 std::vector<Problem>& problems) {
  const std::vector<int> possible = SharingOf(unknown, config, scene);
  const YamlNode* shared = entry.value.Find("shared");
  if (shared == nullptr || shared->text == "true") unknown.sharing = possible;
  if (shared == nullptr || !possible.empty()) return;
  std::string text = fmt::format("the photos have no {} in common", traits.property);
  if (traits.list != renderer::ObjectList::kSensors) {
    text = fmt::format("only photos share what their camera has, not {}", traits.property);
  } else if (unknown.object >= 0) {
    text = fmt::format(
        "this is that of one photo alone; write {}.{}", renderer::kAllSensors, traits.property);
  }
  problems.push_back({shared->place, "unknowns." + entry.key + ".shared", std::move(text)});
}

/// An unknown of one object, whose name is known, from its entry, which may be that of more.
void ReadOne(const YamlEntry& entry,
             const ExperimentConfig& config,
             const renderer::Scene& scene,
             optim::UnknownSpec& unknown,
             std::vector<Problem>& problems) {
  ParameterName found = FindParameter(scene, unknown.name);
  if (found.problem.empty()) found.problem = ProblemOfExposure(unknown, found.parameter, config);
  if (!found.problem.empty()) {
    problems.push_back({entry.key_place, "unknowns", found.problem});
    return;
  }
  unknown.kind = found.parameter.kind;
  unknown.object = found.parameter.object;
  const ParameterTraits& traits = TraitsOf(found.parameter, scene);
  std::vector<Problem> own;
  UnknownReader(entry, traits, PriorsOf(traits), own).Read(unknown);
  ReadSharing(entry, traits, config, scene, unknown, own);
  // Of many objects with one entry each would have the same.
  for (Problem& problem : own) {
    const bool is_known = std::ranges::any_of(problems, [&](const Problem& known) {
      return known.path == problem.path && known.text == problem.text;
    });
    if (!is_known) problems.push_back(std::move(problem));
  }
  SetDefaults(entry.value, config, scene, unknown);
}

/// Patterns may name what stands by itself, too, or what another one does.
void CheckTwice(const Unknowns& unknowns,
                const ExperimentConfig& config,
                std::vector<Problem>& problems) {
  std::map<std::string, std::size_t> first;
  for (std::size_t i = 0; i < unknowns.of_config.size(); ++i) {
    for (const int index : unknowns.of_config[i].front()) {
      const std::string& name = unknowns.specs[static_cast<std::size_t>(index)].name;
      const auto [before, is_new] = first.emplace(name, i);
      if (is_new) continue;
      const auto& entries = config.resolved.Find("unknowns")->entries;
      problems.push_back({entries[i].key_place,
                          "unknowns",
                          fmt::format("'{}' is that of '{}' and of '{}'",
                                      name,
                                      entries[before->second].key,
                                      entries[i].key)});
    }
  }
}

}  // namespace

Unknowns ReadUnknowns(const ExperimentConfig& config, const renderer::Scene& scene) {
  Unknowns result;
  std::vector<optim::UnknownSpec>& unknowns = result.specs;
  std::vector<Problem> problems;
  const std::vector<PromotedUnknown> promotions = ReadPromotions(config, scene, problems);
  // Those beside the first that a pattern names, with the index of its entry.
  std::vector<std::pair<std::size_t, optim::UnknownSpec>> others;
  for (std::size_t i = 0; i < config.fit.unknowns.size(); ++i) {
    const optim::UnknownSpec& item = config.fit.unknowns[i];
    const YamlEntry& entry = config.resolved.Find("unknowns")->entries[i];
    optim::UnknownSpec& unknown = unknowns.emplace_back(item);
    result.of_config.push_back({{static_cast<int>(i)}});
    if (entry.value.Find("as") != nullptr) {
      const auto promoted = std::ranges::find(promotions, i, &PromotedUnknown::index);
      if (promoted == promotions.end()) continue;  // its problem is known
      const ParameterTraits& traits =
          renderer::TraitsOf(promoted->promotion.property, scene, promoted->promotion.material);
      UnknownReader(entry, traits, PriorsOf(*promoted, scene), problems).Read(unknown);
      CheckStartPrior(entry, *promoted, unknown, problems);
      continue;
    }
    const std::vector<std::string> names = NamesLike(scene, item.name);
    for (std::size_t k = 0; k < names.size(); ++k) {
      optim::UnknownSpec one = item;
      one.name = names[k];
      ReadOne(entry, config, scene, one, problems);
      if (k == 0) {
        unknown = std::move(one);
      } else {
        others.emplace_back(i, std::move(one));
      }
    }
  }
  for (auto& [index, other] : others) {
    result.of_config[index].front().push_back(static_cast<int>(unknowns.size()));
    unknowns.push_back(std::move(other));
  }
  CheckTwice(result, config, problems);
  if (!problems.empty()) throw ConfigError(config.source, problems);
  for (const PromotedUnknown& promoted : promotions) {
    const YamlEntry& entry = config.resolved.Find("unknowns")->entries[promoted.index];
    result.of_config[promoted.index] =
        AddForms(promoted, scene, entry.value.Find("priors") != nullptr, unknowns);
  }
  return result;
}

std::string ResolvedYaml(const ExperimentConfig& config, const renderer::Scene& scene) {
  YamlNode root = config.resolved;
  const Unknowns unknowns = ReadUnknowns(config, scene);
  for (std::size_t i = 0; i < unknowns.of_config.size(); ++i) {
    YamlNode& node = root.Find("unknowns")->entries[i].value;
    const auto& forms = unknowns.of_config[i];
    const auto spec = [&](int index) -> const optim::UnknownSpec& {
      return unknowns.specs[static_cast<std::size_t>(index)];
    };
    const optim::UnknownSpec& first = spec(forms.front().front());
    const auto fill = [&node](const char* key, const std::string& yaml) {
      if (node.Find(key) == nullptr) SetDefault(node, key, yaml);
    };
    // Objects that a pattern names may have defaults of their own, which one entry cannot say.
    const auto alike = [&](auto value) {
      return std::ranges::all_of(forms.front(),
                                 [&](int index) { return spec(index).*value == first.*value; });
    };
    using optim::UnknownSpec;
    if (renderer::TraitsOf(first.kind).bounded) {
      if (alike(&UnknownSpec::lower) && alike(&UnknownSpec::upper)) {
        fill("bounds", binding::Write(std::array{first.lower, first.upper}));
      }
      const bool log = first.parameterization == optim::Parameterization::kLog;
      if (alike(&UnknownSpec::parameterization)) fill("transform", log ? "log" : "identity");
    }
    if (!SharingOf(first, config, scene).empty()) {
      fill("shared", first.sharing.empty() ? "false" : "true");
    }
    const bool is_vertices = first.kind == ParameterKind::kVertexPositions;
    if (is_vertices) {
      fill("parametrisation",
           fmt::format("{{large_steps: {{lambda: {}}}}}", first.large_steps_lambda));
    }
    const auto prior = [](const char* name, double weight) {
      return weight > 0.0 ? fmt::format("{{{}: {{weight: {}}}}}", name, weight) : std::string();
    };
    const optim::UnknownSpec& last = spec(forms.back().front());
    fill("priors",
         "[" + prior("laplacian", last.laplacian_weight) + prior("smooth", last.smooth_weight) +
             prior("total_variation", last.total_variation_weight) +
             prior("log_smooth", last.log_smooth_weight) + "]");
    if (is_vertices && alike(&UnknownSpec::mesh_detail)) {
      fill("mesh", first.mesh_detail == optim::MeshDetail::kKeep ? "keep" : "levels");
    }
  }
  return WriteResolvedYaml(root, config.source);
}

}  // namespace pathfit::app
