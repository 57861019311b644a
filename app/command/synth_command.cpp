#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/command/stop_signals.h"
#include "app/config/experiment_config.h"
#include "app/config/nearest_name.h"
#include "app/config/resolved_yaml.h"
#include "app/config/schema.h"
#include "app/experiment/experiment.h"
#include "app/output/export_cameras.h"
#include "app/output/export_result.h"
#include "app/output/fields.h"
#include "app/output/parameter_table.h"
#include "app/output/run_directory.h"
#include "app/output/synthetic_photos.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/image_file.h"
#include "renderer/math/box.h"
#include "renderer/renderer.h"

namespace pathfit::app::synth_command {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFewPhotos = 4;  // of which none is held out

struct SyntheticScene {
  const ExperimentConfig& config;
  const Experiment& experiment;
  std::vector<std::string> names;  ///< file names of the photos
  renderer::Box box;               ///< around all meshes
  bool has_masks = false;          ///< something is seen beside the meshes
};

/// A folder, and how its photos differ from the scene's pictures.
struct PhotoSet {
  fs::path folder;
  PhotoErrors errors;

  [[nodiscard]] double ExposureFactor(std::size_t photo) const {
    return std::exp2(ExposureErrorEv(errors, photo));
  }
  [[nodiscard]] fs::path Mask(const std::string& name) const {
    return folder / "masks" / (name + ".png");
  }
};

/// What the user wrote, without what is the default anyway.
YamlNode Given(const YamlNode& node) {
  YamlNode given = node;
  given.entries.clear();
  for (const YamlEntry& entry : node.entries) {
    if (entry.value.place.source == Place::Source::kDefault) continue;
    given.entries.push_back({entry.key, entry.key_place, Given(entry.value)});
  }
  for (YamlNode& item : given.items) item = Given(item);
  return given;
}

void Erase(YamlNode& map, const std::string& key) {
  std::erase_if(map.entries, [&](const YamlEntry& entry) { return entry.key == key; });
}

/// The `input` of the photos. Exposures that the scene's cameras say are known. `gains`: their
/// errors are unknown.
std::string InputText(const SyntheticScene& scene, bool gains) {
  std::string text = "input:\n  images: photos\n  cameras: {path: transforms.json}\n";
  if (scene.has_masks) text += "  masks: {path: masks, meaning: silhouette}\n";
  std::string known;
  for (std::size_t i = 0; i < scene.names.size(); ++i) {
    const double ev = std::log2(scene.experiment.scene.sensors[i].gain);
    if (ev == 0.0) continue;
    known += fmt::format("{}\"{}\": {:.12g}", known.empty() ? "" : ", ", scene.names[i], ev);
  }
  if (gains || !known.empty()) {
    text += fmt::format("  exposure: {{model: {}{}}}\n",
                        gains ? "gain" : "none",
                        known.empty() ? "" : ", ev: {" + known + "}");
  }
  if (scene.names.size() < kFewPhotos) text += "  split: {validation: none}\n";
  return text;
}

/// A fit of the photos that starts at the truth, but for what is believed of cameras.
std::string FitText(const SyntheticScene& scene, const PhotoErrors& errors) {
  const ExperimentConfig& config = scene.config;
  YamlNode root = Given(config.resolved);
  for (const char* key : {"schema", "name", "input", "output", "gradcheck"}) Erase(root, key);
  if (YamlNode* solver = root.Find("solver")) {  // threads are a matter of this machine
    Erase(*solver, "threads");
    if (solver->entries.empty()) Erase(root, "solver");
  }
  YamlNode& described = *root.Find("scene");
  Erase(described, "sensors");
  if (YamlNode* geometry = described.Find("geometry")) {
    for (YamlEntry& mesh : geometry->entries) Erase(mesh.value, "camera_height_px");
  }
  YamlNode* unknowns = root.Find("unknowns");
  const bool has_unknowns = unknowns != nullptr && !unknowns->entries.empty();
  const bool errs = errors.exposure_sigma_ev > 0.0;
  const bool gains = errs || (has_unknowns && unknowns->Find("exposure") != nullptr);
  // Exposures that are off are no guess of the user's.
  if (has_unknowns && errs && unknowns->Find("exposure") == nullptr) {
    SetDefault(*unknowns, "exposure", "{}");
  }
  std::string text = fmt::format(
      "# Fits the photos beside it, which pathfit synth made. Everything starts at the truth (in "
      "truth/): change the values that are to be found.\nschema: 1\nname: {}\n\n{}\n{}",
      config.name,
      InputText(scene, gains),
      WritePlacedYaml(root, config.source));
  if (!has_unknowns) {
    text += "\n# What is to be found, for example:\n# unknowns: {";
    const auto& meshes = scene.experiment.scene.meshes;
    text += (meshes.empty() ? "MESH" : meshes.front().name) + ".vertices: {}}\n";
  }
  const YamlNode* stages = root.Find("stages");
  if (stages == nullptr || stages->items.empty()) {
    text += fmt::format("\n{}stages: [{{name: all, free: all}}]\n", has_unknowns ? "" : "# ");
  }
  return text;
}

/// The scene as it can be rendered again, with the exposures that the photos had.
std::string TruthText(const SyntheticScene& scene, const std::vector<renderer::Camera>& cameras) {
  ExperimentConfig config = scene.config;
  YamlNode* sensors = config.resolved.Find("scene")->Find("sensors");
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const std::string& name = scene.experiment.scene.sensors[i].name;
    YamlNode* sensor = sensors == nullptr ? nullptr : sensors->Find(name);
    if (sensor == nullptr) continue;
    Erase(*sensor, "exposure_ev");
    SetDefault(*sensor, "exposure_ev", fmt::format("{}", std::log2(cameras[i].gain)));
  }
  return ResolvedYaml(config, scene.experiment.scene);
}

/// Photo and mask of a sensor's picture, which has no errors yet.
void WritePicture(const PhotoSet& set,
                  std::size_t index,
                  const std::string& name,
                  const renderer::Film& film,
                  int quality) {
  const double factor = set.ExposureFactor(index);
  renderer::Image photo = renderer::ColorImage(film);
  for (float& v : photo.data) v *= static_cast<float>(factor);
  AddNoise(set.errors, index, photo);
  WritePhoto(set.folder / "photos" / name, photo, quality);
  renderer::WritePng8(set.Mask(name), renderer::CoverageImage(film));
}

/// Masks of pictures that show nothing but meshes say nothing.
void RemoveMasks(const PhotoSet& set, const std::vector<std::string>& names) {
  std::error_code ignored;
  for (const std::string& name : names) fs::remove(set.Mask(name), ignored);
  fs::remove(set.folder / "masks", ignored);
}

/// Cameras, the truth and a config beside the photos. Returns the config.
fs::path WriteTruth(const PhotoSet& set, const SyntheticScene& scene) {
  renderer::Scene truth = scene.experiment.scene;
  std::vector<renderer::Camera> believed;
  std::vector<std::string> paths;
  std::vector<ExportedView> views;
  for (std::size_t i = 0; i < scene.names.size(); ++i) {
    const std::string& name = scene.names[i];
    renderer::Camera& camera = truth.sensors[i];
    believed.push_back(BelievedCamera(set.errors, i, scene.box, camera));
    paths.push_back("photos/" + name);
    views.push_back({name, (set.folder / "photos" / name).string(), false});
    camera.gain *= set.ExposureFactor(i);
    camera.name = name;
  }
  renderer::WriteFileAtomically(set.folder / "transforms.json", TransformsJson(believed, paths));
  ExportResult(
      set.folder / "truth", truth, views, SummarizeParameters(scene.experiment.fit, truth, truth));
  renderer::WriteFileAtomically(set.folder / "truth" / "scene.yaml",
                                TruthText(scene, truth.sensors));
  const fs::path fit = set.folder / "fit.yaml";
  renderer::WriteFileAtomically(fit, FitText(scene, set.errors));
  static_cast<void>(LoadExperimentConfig(fit, {}));  // one that is refused is a mistake here
  return fit;
}

/// Every sensor's picture into every set, one at a time. Whether something is seen beside the
/// meshes.
bool WritePictures(const std::vector<PhotoSet>& sets,
                   const SyntheticScene& scene,
                   int quality,
                   const renderer::CancelFlag& cancel,
                   Log& log) {
  const renderer::Renderer renderer(scene.experiment.scene);
  renderer::RenderOptions options = scene.config.render;
  bool has_masks = false;
  for (std::size_t i = 0; i < scene.names.size(); ++i) {
    options.view = i;
    const renderer::Film film =
        renderer.RenderPrimal(scene.experiment.scene.sensors[i], options, {.cancel = &cancel});
    has_masks |=
        std::ranges::any_of(film.pixels, [](const renderer::Rgba& pixel) { return pixel.a < 0.5; });
    for (const PhotoSet& set : sets) WritePicture(set, i, scene.names[i], film, quality);
    log.Info("rendered " + scene.names[i]);
  }
  return has_masks;
}

struct Options {
  fs::path output;
  double noise = 0.0, shot_noise = 0.0, exposure_jitter_ev = 0.0, pose_jitter_deg = 0.0;
  int copies = 0;  ///< folders of their own, each with other errors; 0: one set, no such folder
  std::string photo_format = "exr";
  int jpeg_quality = 95;
  bool force = false;
};

void Declare(OptionList& options, Options& own) {
  options.Set();
  options.Seed();
  options.Threads();
  options.Path("-o,--output", "DIR", "Folder for all of it; else synth/NAME here", own.output);
  options.Word("--format",
               "exr|png|jpg",
               "Of the photos; exr is linear, the others 8 bits",
               own.photo_format);
  options.Whole("--quality", "Of JPEG, 1 to 100", 1, 100, own.jpeg_quality);
  options.Override("--spp", "N", "Samples per pixel", "render.spp", OptionList::Form::kWhole, 1);
  options.Number("--noise", "Sigma of normal noise, white being 1", 0.0, 10.0, own.noise);
  options.Number("--shot-noise", "Variance of shot noise of white", 0.0, 10.0, own.shot_noise);
  options.Number("--exposure-jitter",
                 "Sigma of the photos' exposures in EV",
                 0.0,
                 10.0,
                 own.exposure_jitter_ev);
  options.Number("--pose-jitter",
                 "Sigma of what is believed of cameras, in degrees",
                 0.0,
                 90.0,
                 own.pose_jitter_deg);
  options.Whole("--copies", "Sets with errors of their own, in DIR/1 ...", 1, 100000, own.copies);
  options.Flag("--force", "Writes into a folder that is not empty", own.force);
  options.Check([&options, &own] {
    if (options.Given("--quality") && own.photo_format != "jpg") {
      options.Fail("--quality needs --format jpg");
    }
  });
}

/// Names and size of what is to be rendered.
SyntheticScene MakeScene(const ExperimentConfig& config,
                         const Experiment& experiment,
                         const std::string& photo_format,
                         Log& log) {
  SyntheticScene scene{config, experiment, {}, {}};
  for (const renderer::Camera& sensor : experiment.scene.sensors) {
    scene.names.push_back(sensor.name);
    if (sensor.filter != renderer::PixelFilter{}) {
      log.Warn(sensor.name +
               ": its pixel filter is not known to a fit, which takes photos for means "
               "over pixels");
    }
  }
  scene.names = ViewFolderNames(scene.names);
  for (std::string& name : scene.names) name += "." + photo_format;
  for (const renderer::Mesh& mesh : renderer::WorldMeshes(experiment.scene)) {
    scene.box.Include(renderer::BoxAround(mesh.positions));
  }
  return scene;
}

constexpr ResultKey kResult[] = {
    {"sets", "list", "Maps with folder, photos (number), masks (boolean), config and truth"}};

ExitStatus Run(CommandContext& context, const Options& own) {
  const CommandLine& line = context.line;
  const ExperimentConfig config = LoadExperimentConfig(line.target, line.overrides);
  const renderer::ThreadLimit limit(NumThreads(line, config.threads));
  const fs::path folder =
      fs::absolute(own.output.empty() ? fs::path("synth") / config.name : own.output)
          .lexically_normal();
  if (!own.force && fs::exists(folder) && !fs::is_empty(folder)) {
    throw UsageError(
        "synth",
        folder.string() + " is not empty; -o names another folder, --force writes into it");
  }
  const Experiment experiment = BuildExperiment(config);
  for (const std::string& text : experiment.warnings) context.log.Warn(text);

  SyntheticScene scene = MakeScene(config, experiment, own.photo_format, context.log);
  std::vector<PhotoSet> written;
  for (int copy = 1; copy <= std::max(1, own.copies); ++copy) {
    written.push_back({own.copies > 0 ? folder / std::to_string(copy) : folder,
                       {config.render.seed + static_cast<std::uint64_t>(copy - 1),
                        own.noise,
                        own.shot_noise,
                        own.exposure_jitter_ev,
                        own.pose_jitter_deg * std::numbers::pi / 180.0}});
    for (const char* part : {"photos", "masks", "truth"}) {
      renderer::CreateFolders(written.back().folder / part);
    }
  }
  const StopSignals signals;
  try {
    scene.has_masks = WritePictures(written, scene, own.jpeg_quality, signals.flag(), context.log);
  } catch (const renderer::Cancelled&) {
    context.log.Warn("stopped: " + folder.string() + " holds only some of the photos");
    return signals.Received().value_or(ExitStatus::kStopped);
  }
  Json sets = Json::array();
  for (const PhotoSet& set : written) {
    if (!scene.has_masks) RemoveMasks(set, scene.names);
    const fs::path fit = WriteTruth(set, scene);
    sets.push_back({{"folder", set.folder.string()},
                    {"photos", scene.names.size()},
                    {"masks", scene.has_masks},
                    {"config", fit.string()},
                    {"truth", (set.folder / "truth").string()}});
    if (!line.json) fmt::print("{}\n", set.folder.string());
  }
  if (line.json) PrintResult(context, {{"sets", std::move(sets)}});
  context.log.Info(
      "fit.yaml starts at the truth: change what is to be found, or begin from the photos alone by "
      "pathfit init DIR; pathfit eval RUN --truth DIR says how near a fit came");
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kSynthCommand = {"synth",
                                      "Makes photos, masks and cameras of a scene, with its truth",
                                      "CONFIG",
                                      Prepare<Options, Declare, Run>,
                                      kResult};

}  // namespace pathfit::app::synth_command
