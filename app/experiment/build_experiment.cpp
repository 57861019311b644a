#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <set>
#include <variant>

#include <fmt/format.h>

#include "app/config/nearest_name.h"
#include "app/config/schema.h"
#include "app/experiment/build_parts.h"
#include "app/experiment/experiment.h"
#include "app/experiment/photo_names.h"
#include "optim/observation/load_observations.h"
#include "optim/observation/located_point.h"
#include "optim/observation/observation_stream.h"
#include "optim/observation/photo_file.h"
#include "optim/ranks/division.h"
#include "renderer/core/error.h"
#include "renderer/core/process_memory.h"
#include "renderer/derivative/derivative_limits.h"

namespace pathfit::app {
namespace {

using renderer::ParameterKind;

/// Around the start, unless something else is asked for: without it, nothing says where all cameras
/// and objects are together. Absent for what is no camera's.
std::optional<optim::GaussianPriorSpec> DefaultPrior(ParameterKind kind,
                                                     const renderer::Scene& scene) {
  const auto deviation = renderer::TraitsOf(kind).believed;
  if (deviation == nullptr) return std::nullopt;
  return optim::GaussianPriorSpec{{}, deviation(scene)};
}

/// The credit paragraph of a README.md beside an input file: photos under a licence that asks for
/// it keep it in reports.
std::string FindAttribution(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "README.md";
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return {};  // to open a pipe is to wait
  std::ifstream file(path);
  std::string text;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    const bool begins = line.rfind("**Source**", 0) == 0 || line.rfind("**Source.**", 0) == 0;
    inside = begins || (inside && !line.empty());
    if (inside) text += (text.empty() ? "" : " ") + line;
  }
  text.erase(std::remove(text.begin(), text.end(), '*'), text.end());
  return text;
}

/// File names of the pictures that the one camera took; empty: all.
std::vector<std::string> PhotosOfSensor(const ExperimentConfig& config) {
  if (config.input->sensor_photos.empty()) return {};
  std::vector<std::string> names;
  for (const std::filesystem::path& path : optim::PicturesIn(config.input->photos.images_dir)) {
    names.push_back(path.filename().string());
  }
  const PhotoNames photos(names);
  std::vector<Problem> problems;
  const YamlNode& patterns = *config.resolved.Find("input")->Find("cameras")->Find("photos");
  for (const YamlNode& pattern : patterns.items) {
    photos.RequireMatch(pattern.text, pattern.place, "input.cameras.photos", problems);
  }
  if (!problems.empty()) throw ConfigError(config.source, problems);
  std::vector<std::filesystem::path> taken;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::ranges::any_of(config.input->sensor_photos,
                            [&](const auto& pattern) { return photos.Matches(pattern, i); })) {
      taken.emplace_back(names[i]);
    }
  }
  names.clear();
  for (const std::filesystem::path& path : optim::WithoutRawTwins(std::move(taken))) {
    names.push_back(path.string());
  }
  return names;
}

std::vector<std::string> ViewNames(const optim::ObservationSet& observations) {
  std::vector<std::string> names;
  for (const optim::View& view : observations.views) names.push_back(view.name);
  return names;
}

void SetKnownExposures(const ExperimentConfig& config,
                       optim::ObservationSet& observations,
                       std::vector<Problem>& problems) {
  if (config.input->known_ev.empty()) return;
  const std::vector<std::string> names = ViewNames(observations);
  const PhotoNames photos(names);
  std::vector<std::string> given_by(names.size());
  const YamlNode& known = *config.resolved.Find("input")->Find("exposure")->Find("ev");
  for (std::size_t k = 0; k < known.entries.size(); ++k) {
    const auto& [pattern, ev] = config.input->known_ev[k];
    const Place& place = known.entries[k].key_place;
    photos.RequireMatch(pattern, place, "input.exposure.ev", problems);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (!photos.Matches(pattern, i)) continue;
      if (!given_by[i].empty()) {
        problems.push_back({place,
                            "input.exposure.ev",
                            "'" + names[i] + "' has one by '" + given_by[i] + "' already"});
      }
      given_by[i] = pattern;
      observations.views[i].camera.gain *= std::exp2(ev);
    }
  }
}

/// A point of `input.scale` and what is known of it; empty with a problem.
class ScalePointFinder {
 public:
  ScalePointFinder(const optim::ObservationSet& observations, std::vector<Problem>& problems)
      : observations_(observations), names_(ViewNames(observations)), problems_(problems) {}

  std::optional<optim::LocatedPoint> Find(const ScalePoint& point,
                                          const YamlNode& node,
                                          const std::string& key) {
    const auto& [x, y, z] = point.position;
    if (point.picks.empty()) return optim::LocatedPoint{{x, y, z}, {}};
    const PhotoNames photos(names_);
    const std::size_t num_before = problems_.size();
    std::vector<optim::PickedPoint> picks;
    for (std::size_t k = 0; k < point.picks.size(); ++k) {
      const auto& [pattern, pixel] = point.picks[k];
      const YamlEntry& entry = node.entries[k];
      photos.RequireMatch(pattern, entry.key_place, key, problems_);
      std::vector<std::size_t> views;
      for (std::size_t i = 0; i < names_.size(); ++i) {
        if (photos.Matches(pattern, i)) views.push_back(i);
      }
      if (views.empty()) continue;
      const std::size_t view = views.front();
      if (views.size() > 1) {
        Report(
            entry.key_place, key, fmt::format("'{}' stands for {} photos", pattern, views.size()));
      } else if (std::ranges::find(picks, view, &optim::PickedPoint::view) != picks.end()) {
        Report(entry.key_place, key, "'" + names_[view] + "' is there twice");
      } else if (!optim::IsInPhoto(observations_.views[view], pixel[0], pixel[1])) {
        Report(entry.value.place, key, "the pixel is outside of " + names_[view]);
      } else {
        picks.push_back({view, pixel[0], pixel[1]});
      }
    }
    if (problems_.size() > num_before) return std::nullopt;
    try {
      return optim::LocatePoint(observations_.views, picks);
    } catch (const renderer::SceneError& error) {
      Report(node.place, key, error.what());
      return std::nullopt;
    }
  }

 private:
  void Report(const Place& place, const std::string& key, const std::string& text) {
    problems_.push_back({place, key, text});
  }

  const optim::ObservationSet& observations_;
  std::vector<std::string> names_;
  std::vector<Problem>& problems_;
};

/// " (picked in photos, to 0.4, 0.7 pixels)"; empty of points that are numbers.
std::string PicksText(const std::vector<double>& off_px) {
  if (off_px.empty()) return "";
  std::string text;
  for (const double off : off_px) text += fmt::format("{}{:.1f}", text.empty() ? "" : ", ", off);
  return " (picked in photos, to " + text + " pixels)";
}

constexpr double kLeastLength = 1e-9;  // of how far the points are from the frame's origin

void SetKnownScale(const ExperimentConfig& config,
                   optim::ObservationSet& observations,
                   std::vector<Problem>& problems) {
  if (!config.input->scale) return;
  const YamlNode& nodes = *config.resolved.Find("input")->Find("scale")->Find("two_points");
  ScalePointFinder finder(observations, problems);
  std::vector<optim::LocatedPoint> ends;
  std::vector<double> off_px;
  for (std::size_t i = 0; i < config.input->scale->two_points.size(); ++i) {
    const auto end = finder.Find(config.input->scale->two_points[i],
                                 nodes.items[i],
                                 fmt::format("input.scale.two_points[{}]", i));
    if (!end) continue;
    ends.push_back(*end);
    off_px.insert(off_px.end(), end->off_px.begin(), end->off_px.end());
  }
  if (ends.size() < 2) return;
  const double length = Norm(ends[1].position - ends[0].position);
  const double metres_per_unit = config.input->scale->distance_m / length;
  const double farthest = std::max(Norm(ends[0].position), Norm(ends[1].position));
  if (!(length > kLeastLength * farthest) || !std::isnormal(metres_per_unit)) {
    const bool is_far = std::isinf(farthest) || std::isinf(length);
    problems.push_back({nodes.place,
                        "input.scale.two_points",
                        is_far ? "the points are too far away" : "both points are the same"});
    return;
  }
  optim::SetMetresPerUnit(metres_per_unit,
                          fmt::format("as two points {:.4g} units apart{} are {:.4g} m",
                                      length,
                                      PicksText(off_px),
                                      config.input->scale->distance_m),
                          observations);
}

/// The gains start as the cameras noted, unless the config says exposures of its own.
void UseExifExposures(const ExperimentConfig& config, Experiment& experiment) {
  std::vector<optim::View>& views = experiment.observations.views;
  const auto [low, high] = std::ranges::minmax_element(views, {}, &optim::View::exif_ev);
  if (views.empty() || low->exif_ev == high->exif_ev) return;
  if (config.input->exposure_model == ExposureUnknown::kNone || !config.input->known_ev.empty()) {
    experiment.assumptions.push_back(fmt::format(
        "Exposure: EXIF is not used, since {}.",
        config.input->known_ev.empty() ? "input.exposure.model is none; with gain it is the start"
                                       : "input.exposure.ev says exposures"));
    return;
  }
  for (optim::View& view : views) view.camera.gain *= std::exp2(static_cast<double>(view.exif_ev));
  experiment.assumptions.push_back(
      fmt::format("Exposure: the gains start as EXIF says, from {:.2f} to {:+.2f} EV around their "
                  "mean; for another start write input.exposure.ev.",
                  low->exif_ev,
                  high->exif_ev));
}

/// Nothing tells what a light does that is off in all photos that are fitted.
void WarnOfUnseenLights(Experiment& experiment) {
  const auto& views = experiment.observations.views;
  if (views.empty()) return;
  for (const renderer::Camera& sensor : experiment.scene.sensors) {
    if (!sensor.lights_off.empty() &&
        sensor.lights_off.size() == experiment.scene.emitters.size()) {
      experiment.warnings.push_back(sensor.name +
                                    ": no light shines in this photo (`photos` of the lights)");
    }
  }
  for (const optim::UnknownSpec& unknown : experiment.fit.unknowns) {
    if (renderer::TraitsOf(unknown.kind).list != renderer::ObjectList::kEmitters) continue;
    bool shines = false;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const auto& off = experiment.scene.sensors[i].lights_off;
      shines = shines || (!views[i].validation && !renderer::IsOff(off, unknown.object));
    }
    if (shines || unknown.hold) continue;
    experiment.warnings.push_back(
        unknown.name + ": the light shines in no fitted photo, so that it stays where it starts");
  }
}

// Puts the place of the object that is wrong before the message.
[[noreturn]] void ThrowWithPlace(const renderer::SceneError& error,
                                 const ExperimentConfig& config) {
  const std::string text = error.what();
  for (const auto& [object, place] : config.places) {
    if (text.starts_with(object)) throw renderer::SceneError(place + ": " + text);
  }
  throw error;
}

/// What the config says of photos, beside where they are.
void UsePhotos(const ExperimentConfig& config,
               optim::ObservationSet photos,
               Experiment& experiment) {
  experiment.observations = std::move(photos);
  std::vector<Problem> problems;
  SetKnownExposures(config, experiment.observations, problems);
  SetKnownScale(config, experiment.observations, problems);
  if (!problems.empty()) throw ConfigError(config.source, problems);
  experiment.assumptions = experiment.observations.assumptions;
  UseExifExposures(config, experiment);
}

/// Photos, cameras and what is known of them.
void LoadPhotos(const ExperimentConfig& config, optim::Ranks& ranks, Experiment& experiment) {
  std::vector<optim::InputFile> files;
  optim::ObservationOptions options = config.input->photos;
  const auto sensor = std::ranges::find(config.sensors, config.input->sensor, &SensorConfig::name);
  if (sensor != config.sensors.end()) {
    options.fixed_camera = BuildSensor(*sensor);
    options.fixed_photos = PhotosOfSensor(config);
  }
  optim::ObservationSet observations;
  if (ranks.IsFirst()) observations = optim::LoadObservations(options, &files);
  if (!ranks.IsAlone()) {
    const optim::Bytes known =
        optim::Division(&ranks, nullptr)
            .Share(ranks.IsFirst() ? optim::EncodeObservations(observations) : optim::Bytes());
    if (!ranks.IsFirst()) observations = optim::DecodeObservations(known, options);
  }
  for (const optim::InputFile& file : files) experiment.input_files.push_back(file.path);
  UsePhotos(config, std::move(observations), experiment);
}

void GiveDefaultPriors(const ExperimentConfig& config, Experiment& experiment) {
  for (optim::UnknownSpec& unknown : experiment.fit.unknowns) {
    if (unknown.gaussian) continue;
    unknown.gaussian = DefaultPrior(unknown.kind, experiment.scene);
    if (unknown.gaussian && !unknown.hold && config.input) {
      experiment.assumptions.push_back(
          fmt::format("{} is believed to be near its start, within {:.3g} (one sigma); write a "
                      "gaussian prior for another belief.",
                      unknown.name,
                      unknown.gaussian->sigma));
    }
  }
}

/// What may be meant otherwise.
void RemarkOnUnknowns(Experiment& experiment) {
  for (const optim::UnknownSpec& unknown : experiment.fit.unknowns) {
    if (!unknown.sharing.empty() && !unknown.hold) {
      const std::set<int> different(unknown.sharing.begin(), unknown.sharing.end());
      experiment.assumptions.push_back(
          different.size() == 1
              ? fmt::format("{} is one for all {} photos.", unknown.name, unknown.sharing.size())
              : fmt::format("{}: {} for {} photos, one for each size and lens at the start.",
                            unknown.name,
                            different.size(),
                            unknown.sharing.size()));
    }
    if (unknown.kind != ParameterKind::kVertexPositions || unknown.hold) continue;
    const auto& mesh = experiment.scene.meshes[static_cast<std::size_t>(unknown.object)];
    if (!mesh.mesh.normals.empty()) {
      experiment.assumptions.push_back("The shading normals of " + mesh.name +
                                       " stay as they are when its vertices move; normals: flat "
                                       "lets them follow.");
    }
  }
}

void RemarkOnStarts(const ExperimentConfig& config, Experiment& experiment) {
  for (const GeometryConfig& mesh : config.geometry) {
    if (!std::holds_alternative<VisualHullGeometry>(mesh.geometry)) continue;
    experiment.assumptions.push_back(
        "Start of " + mesh.name +
        ": carved from the masks, which fill hollows that no outline shows, such as the inside of "
        "a bowl; a fit opens them in part only. For one that has them write {file: mesh.ply}.");
  }
}

/// Beside the input files, each once.
std::vector<std::string> FindAttributions(const std::vector<std::filesystem::path>& files) {
  std::set<std::filesystem::path> folders;
  std::vector<std::string> credits;
  for (const std::filesystem::path& file : files) {
    if (!folders.insert(file.parent_path()).second) continue;
    std::string text = FindAttribution(file.parent_path());
    if (!text.empty() && !Contains(credits, text)) credits.push_back(std::move(text));
  }
  return credits;
}

/// Only the scene knows all materials.
void CheckGauge(const ExperimentConfig& config, const renderer::Scene& scene) {
  const std::string& name = config.fit.gauge.material;
  const std::vector<std::string> names =
      renderer::ObjectNames(scene, renderer::ObjectList::kMaterials);
  if (name.empty() || Contains(names, name)) return;
  const Place place = config.resolved.Find("gauge")->Find("material")->place;
  throw ConfigError(
      config.source,
      {{place, "gauge.material", "there is no material '" + name + "'" + NameHint(name, names)}});
}

/// Scene and unknowns, for the photos that `experiment` has.
void Complete(const ExperimentConfig& config, Experiment& experiment) {
  experiment.warnings = UselessValues(config);
  try {
    experiment.scene = BuildScene(config, experiment);
  } catch (const renderer::SceneError& error) {
    ThrowWithPlace(error, config);
  }
  experiment.observations.black_background = !renderer::ShowsEnvironment(experiment.scene);
  experiment.fit = BuildFitSpec(config, experiment.scene);
  GiveDefaultPriors(config, experiment);
  RemarkOnStarts(config, experiment);
  RemarkOnUnknowns(experiment);
  WarnOfUnseenLights(experiment);
  experiment.attributions = FindAttributions(experiment.input_files);
}

/// Of derivatives by what is unknown.
renderer::DerivativeForm FormOf(const std::vector<optim::UnknownSpec>& unknowns,
                                const renderer::Scene& scene) {
  renderer::ParameterLayout layout(scene);
  const bool cameras_move = std::ranges::any_of(unknowns, [](const optim::UnknownSpec& unknown) {
    return !unknown.hold && renderer::MovesGeometry(unknown.kind) &&
           renderer::TraitsOf(unknown.kind).list == renderer::ObjectList::kSensors;
  });
  if (cameras_move) layout.Add(renderer::ParameterKind::kCameraPosition, 0);
  return renderer::DefaultForm(scene, layout);
}

}  // namespace

optim::FitSpec BuildFitSpec(const ExperimentConfig& config, const renderer::Scene& scene) {
  optim::FitSpec fit = config.fit;
  Unknowns unknowns = ReadUnknowns(config, scene);
  fit.unknowns = std::move(unknowns.specs);
  std::vector<std::size_t> times_freed(unknowns.of_config.size(), 0);
  for (optim::StageSpec& stage : fit.stages) {
    std::vector<int> free;
    for (const int index : stage.free) {
      const auto& forms = unknowns.of_config[static_cast<std::size_t>(index)];
      std::size_t& times = times_freed[static_cast<std::size_t>(index)];
      const std::vector<int>& now = forms[std::min(times++, forms.size() - 1)];
      free.insert(free.end(), now.begin(), now.end());
    }
    stage.free = std::move(free);
  }
  CheckGauge(config, scene);
  if (config.input) fit.exposure = config.input->exposure;
  fit.seed = config.render.seed;
  fit.max_memory_bytes =
      config.max_memory_bytes > 0.0 ? config.max_memory_bytes : renderer::MemoryLimit();
  fit.estimators = config.render;
  if (!config.derivative.form) fit.estimators.form = FormOf(fit.unknowns, scene);
  return fit;
}

Experiment BuildExperiment(const ExperimentConfig& config) {
  optim::Ranks alone;
  return BuildExperiment(config, alone);
}

Experiment BuildExperiment(const ExperimentConfig& config, optim::Ranks& ranks) {
  Experiment experiment;
  if (config.input) LoadPhotos(config, ranks, experiment);
  Complete(config, experiment);
  return experiment;
}

Experiment BuildExperiment(const ExperimentConfig& config, optim::ObservationSet photos) {
  Experiment experiment;
  UsePhotos(config, std::move(photos), experiment);
  Complete(config, experiment);
  return experiment;
}

}  // namespace pathfit::app
