#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <set>
#include <string_view>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/command/run_scene.h"
#include "app/command/stop_signals.h"
#include "app/config/experiment_config.h"
#include "app/config/nearest_name.h"
#include "app/experiment/build_parts.h"
#include "app/experiment/direction.h"
#include "app/experiment/experiment.h"
#include "app/experiment/orbit.h"
#include "app/output/fields.h"
#include "app/output/report_images.h"
#include "app/output/run_directory.h"
#include "app/output/signed_image.h"
#include "optim/observation/camera_import.h"
#include "optim/ranks/division.h"
#include "optim/ranks/film_stream.h"
#include "renderer/budget_search.h"
#include "renderer/core/error.h"
#include "renderer/derivative/derivative_limits.h"
#include "renderer/derivative/film_sink.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/image_file.h"
#include "renderer/renderer.h"

namespace pathfit::app::render_command {
namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path output;
  std::vector<std::string> views;        ///< indices or names of photos or sensors; empty: all
  std::vector<std::string> derivatives;  ///< parameters
  fs::path cameras;                      ///< to render instead of the scene's
  fs::path environment;                  ///< that lights the scene instead of its lights
  std::string stage;                     ///< of a run; empty: the newest state
  int orbit = 0;                         ///< number of cameras on a circle; 0: none
};

/// Names of sensors that are meant by one that is none: without its extension, or nearly right.
std::string SensorHint(const renderer::Scene& scene, const std::string& wanted) {
  std::vector<std::string> names;
  for (const renderer::Camera& sensor : scene.sensors) {
    names.push_back(sensor.name);
    if (fs::path(sensor.name).stem() == wanted) return " (did you mean '" + sensor.name + "'?)";
  }
  return NameHint(wanted, names);
}

/// Sensors by index or name, in the scene's order; all without a choice.
std::vector<int> ChooseSensors(const renderer::Scene& scene,
                               const std::vector<std::string>& wanted) {
  const int count = static_cast<int>(scene.sensors.size());
  std::set<int> chosen;
  for (const std::string& w : wanted) {
    bool known = false;
    for (int i = 0; i < count; ++i) {
      const std::string& name = scene.sensors[static_cast<std::size_t>(i)].name;
      if (w != name && w != std::to_string(i) && w != "all") continue;
      chosen.insert(i);
      known = true;
    }
    if (!known) {
      throw renderer::SceneError("no sensor or photo is called '" + w + "'" + SensorHint(scene, w) +
                                 "; there are " + std::to_string(count) + ", numbered from 0");
    }
  }
  if (wanted.empty()) {
    for (int i = 0; i < count; ++i) chosen.insert(i);
  }
  return {chosen.begin(), chosen.end()};
}

void WriteFilm(const renderer::Film& film, const fs::path& stem, std::vector<fs::path>& written) {
  const fs::path exr = stem.string() + ".exr";
  const fs::path png = stem.string() + ".png";
  const fs::path alpha = stem.string() + "_coverage.exr";
  const renderer::Image color = renderer::ColorImage(film);
  renderer::WriteExr(exr, color);
  renderer::WriteExr(alpha, renderer::CoverageImage(film));
  renderer::WritePng8(png, EncodedImage(color));
  written.insert(written.end(), {exr, alpha, png});
}

void WriteDerivative(const renderer::Film& film,
                     const fs::path& stem,
                     Log& log,
                     std::vector<fs::path>& written) {
  const fs::path exr = stem.string() + ".exr";
  const fs::path alpha = stem.string() + "_coverage.exr";
  const fs::path png = stem.string() + ".png";
  const double scale = SignedScale(film);
  renderer::WriteExr(exr, renderer::ColorImage(film));
  renderer::WriteExr(alpha, renderer::CoverageImage(film));
  renderer::WritePng8(png, SignedImage(film, scale));
  log.Info(fmt::format(
      "{}: white is 0, full red +{:.4g}, full blue -{:.4g}", png.string(), scale, scale));
  written.insert(written.end(), {exr, alpha, png});
}

/// All groups that the directions need.
renderer::ParameterLayout UnionLayout(const renderer::Scene& scene,
                                      const std::vector<Direction>& directions) {
  renderer::ParameterLayout layout(scene);
  for (const Direction& direction : directions) {
    for (const renderer::ParameterGroup& group : direction.layout.groups()) {
      if (layout.FirstBlock(group.kind, group.object) < 0) {
        layout.Add(group.kind, group.object, group.sharing);
      }
    }
  }
  return layout;
}

/// The direction's values at their places in a larger layout, zero elsewhere.
std::vector<double> ValuesIn(const renderer::ParameterLayout& layout, const Direction& direction) {
  std::vector<double> values(static_cast<std::size_t>(layout.NumScalars()), 0.0);
  for (const renderer::ParameterGroup& group : direction.layout.groups()) {
    const std::int64_t to = layout.FirstScalarOfBlock(layout.FirstBlock(group.kind, group.object));
    const auto first = direction.values.begin() + group.first_scalar;
    std::copy_n(first, group.NumScalars(), values.begin() + to);
  }
  return values;
}

struct Target {
  ExperimentConfig config;
  Experiment experiment;
};

/// A config, or a run with its newest state.
Target LoadTarget(CommandContext& context, const std::string& stage) {
  const CommandLine& line = context.line;
  if (fs::is_directory(line.target)) {
    RunScene loaded = LoadRunScene(context, line.target, stage);
    return {std::move(loaded.config), std::move(loaded.experiment)};
  }
  if (!stage.empty()) throw UsageError("render", "--stage needs a run, not a config");
  ExperimentConfig config = LoadExperimentConfig(line.target, line.overrides);
  const renderer::ThreadLimit limit(NumThreads(line, config.threads));
  Experiment experiment = BuildExperiment(config, context.ranks);
  for (const std::string& text : experiment.assumptions) context.log.Info(text);
  for (const std::string& text : experiment.warnings) context.log.Warn(text);
  return {std::move(config), std::move(experiment)};
}

/// Lit by the picture alone, its up being that of the cameras, which show radiance as it is.
void Relight(const fs::path& picture, renderer::Scene& scene) {
  renderer::EnvironmentEmitter light = ReadUprightEnvironment(picture, "--env", UpDirection(scene));
  scene.emitters = {{"environment", renderer::LightFrame::kWorld, {}, std::move(light)}};
  for (renderer::Camera& camera : scene.sensors) {
    camera.ForgetResponse();
    camera.lights_off.clear();
  }
}

/// Those of a camera file, which must say their size.
std::vector<renderer::Camera> CamerasOfFile(const fs::path& path) {
  std::vector<renderer::Camera> cameras;
  for (const optim::ImportedCamera& imported : optim::ImportCameras(path, "auto").cameras) {
    if (imported.camera.width == 0) {
      throw renderer::IoError(imported.place + ": says no size of its picture (w, h)");
    }
    cameras.push_back(
        optim::CompleteCamera(imported, imported.camera.width, imported.camera.height));
    cameras.back().name = imported.image;
  }
  if (cameras.empty()) throw renderer::IoError(path.string() + ": has no posed photo");
  return cameras;
}

/// What the options make of the scene.
void ChangeScene(const Options& own, renderer::Scene& scene) {
  if (!own.environment.empty()) Relight(own.environment, scene);
  if (!own.cameras.empty()) scene.sensors = CamerasOfFile(own.cameras);
  if (own.orbit > 0) scene.sensors = OrbitCameras(scene, own.orbit);
  renderer::ValidateScene(scene);
}

/// "orbit:24" is 24; 0 for what is no orbit.
int OrbitCount(const OptionList& options, const std::vector<std::string>& views) {
  constexpr std::string_view kOrbit = "orbit:";
  constexpr int kMost = 10000;
  if (views.empty() || !views.front().starts_with(kOrbit)) return 0;
  const std::string& word = views.front();
  int count = 0;
  const char* last = word.data() + word.size();
  const auto [end, error] = std::from_chars(word.data() + kOrbit.size(), last, count);
  if (views.size() > 1 || error != std::errc() || end != last || count < 1 || count > kMost) {
    options.Fail("--views: '" + word +
                 "' is not understood; write orbit:24 for 24 cameras on a circle, alone");
  }
  return count;
}

void LogStats(const renderer::RenderStats& stats, Log& log) {
  if (stats.non_finite_samples > 0) {
    log.Warn(fmt::format(
        "{} samples of {} were not finite and left out", stats.non_finite_samples, stats.paths));
  }
}

Direction NamedDirection(const renderer::Scene& scene, const std::string& name) {
  try {
    return ParseDirection(scene, name);
  } catch (const renderer::SceneError& error) {
    throw UsageError("render", std::string("--derivative: ") + error.what());
  }
}

void Declare(OptionList& options, Options& own) {
  using Form = OptionList::Form;
  options.Set();
  options.Seed();
  options.Threads();
  options.Path("-o,--output", "DIR", "Where images go", own.output);
  options.List(
      "--views",
      "LIST",
      "Photos by index or name, e.g. 0,3,8; all; or orbit:24 on a circle, numbered pictures that "
      "become a film by: ffmpeg -framerate 24 -i orbit_%03d.png -pix_fmt yuv420p orbit.mp4",
      own.views);
  options.Path("--cameras", "PATH", "Cameras to render, of a camera file or folder", own.cameras);
  options.Path("--env", "FILE", "Lights the scene by this EXR or HDR alone", own.environment);
  options.Text("--stage", "STAGE", "Of a run: its state after a stage, or start", own.stage);
  options.Texts("--sensor", "NAME", "A sensor or photo; may be repeated", own.views);
  options.Override("--spp", "N", "Samples per pixel", "render.spp", Form::kWhole, 1);
  options.Texts("--derivative", "PARAM", "Derivative image; may be repeated", own.derivatives);
  options.Override(
      "--terms",
      TypeOfWords(renderer::kDerivativeTerms, ',', [](const auto& term) { return term.first; }),
      "Of the derivative",
      "render.terms",
      Form::kWords);
  options.Override("--form", "image|material", "Of the derivative", "render.form", Form::kWord);
  options.Check([&options, &own] {
    own.orbit = OrbitCount(options, own.views);
    if (own.orbit > 0) own.views.clear();
    for (const char* flag : {"--cameras", "--env"}) {
      if (options.Given(flag) && !own.derivatives.empty()) {
        options.Fail(std::string(flag) + " and --derivative exclude each other");
      }
    }
    if (own.orbit > 0 && (options.Given("--cameras") || !own.derivatives.empty())) {
      options.Fail("--views orbit: excludes --cameras and --derivative");
    }
    if (options.Given("--views") && options.Given("--sensor")) {
      options.Fail("--views and --sensor exclude each other");
    }
    if (options.Given("--views") && own.views.size() == 1 && own.views.front() == "all") {
      own.views.clear();
    }
    for (const char* flag : {"--terms", "--form"}) {
      if (options.Given(flag) && own.derivatives.empty()) {
        options.Fail(std::string(flag) + " needs --derivative");
      }
    }
  });
}

/// "form image, spp 64, sppe 3.1, spp_direct 20": of the terms that can be there.
std::string WordsOf(const renderer::RenderOptions& options) {
  constexpr std::array kNames = {"sppe", "spp_direct", "spp_indirect", "spp_pixel"};
  std::string words =
      fmt::format("form {}, spp {}",
                  options.form == renderer::DerivativeForm::kImage ? "image" : "material",
                  options.spp);
  for (std::size_t t = 0; t < kNames.size(); ++t) {
    if (!options.Has(renderer::kDerivativeTerms[t + 1].second)) continue;
    words += fmt::format(", {} {:.3g}", kNames[t], options.*renderer::kBoundaryBudgets[t]);
  }
  return words;
}

/// An image, or the derivative images of one rendering.
struct Rendering {
  std::vector<renderer::Film> films;
  renderer::RenderStats stats;
  std::string settings;  ///< of derivatives by what moves

  static void VisitParts(auto& rendering, const auto& visit) {
    visit(rendering.films);
    visit(rendering.stats);
    visit(rendering.settings);
  }
};

/// What is rendered, by view: first its image, then its derivatives.
class Pictures {
 public:
  Pictures(const renderer::Scene& scene,
           const renderer::RenderOptions& options,
           const renderer::DerivativeChoice& given,
           std::vector<Direction> directions,
           std::vector<int> sensors,
           fs::path folder)
      : scene_(scene),
        options_(options),
        given_(given),
        directions_(std::move(directions)),
        sensors_(std::move(sensors)),
        folder_(std::move(folder)),
        layout_(UnionLayout(scene, directions_)),
        renderer_(scene) {
    for (const Direction& direction : directions_) values_.push_back(ValuesIn(layout_, direction));
    for (const renderer::Camera& sensor : scene.sensors) names_.push_back(sensor.name);
    names_ = ViewFolderNames(names_);
  }

  [[nodiscard]] std::size_t Count() const { return sensors_.size() * NumParts(); }

  [[nodiscard]] Rendering Render(std::size_t i, const renderer::CancelFlag& cancel) const {
    const std::size_t sensor = SensorOf(i);
    const renderer::Camera& camera = scene_.sensors[sensor];
    renderer::RenderOptions options = options_;
    options.view = sensor;
    Rendering rendering;
    const renderer::RenderServices services{.cancel = &cancel, .stats = &rendering.stats};
    if (IsImage(i)) {
      rendering.films.push_back(renderer_.RenderPrimal(camera, options, services));
      return rendering;
    }
    renderer::FilmSinks sink(layout_, values_, camera.width, camera.height);
    options.with_image = false;
    options = renderer::ChooseDerivative(
        renderer_, {camera, static_cast<int>(sensor), layout_, values_}, options, given_, &cancel);
    if (layout_.AnyKind(renderer::MovesGeometry)) rendering.settings = WordsOf(options);
    renderer_.RenderDerivative(camera, static_cast<int>(sensor), options, layout_, sink, services);
    for (std::size_t d = 0; d < directions_.size(); ++d) rendering.films.push_back(sink.film(d));
    return rendering;
  }

  void Write(std::size_t i, const Rendering& rendering, Log& log) {
    const std::string& name = names_[SensorOf(i)];
    LogStats(rendering.stats, log);
    if (IsImage(i)) {
      WriteFilm(rendering.films.front(), folder_ / name, files_);
    } else if (!rendering.settings.empty()) {
      log.Info("derivatives seen by " + scene_.sensors[SensorOf(i)].name + ": " +
               rendering.settings);
    }
    for (std::size_t d = 0; d < directions_.size() && !IsImage(i); ++d) {
      const std::string file = name + "_d_" + SafeFileName(directions_[d].name);
      WriteDerivative(rendering.films[d], folder_ / file, log, files_);
    }
    if ((i + 1) % NumParts() == 0) log.Info("rendered " + scene_.sensors[SensorOf(i)].name);
  }

  [[nodiscard]] const std::vector<fs::path>& files() const { return files_; }

 private:
  [[nodiscard]] std::size_t NumParts() const { return directions_.empty() ? 1 : 2; }
  [[nodiscard]] bool IsImage(std::size_t i) const { return i % NumParts() == 0; }
  [[nodiscard]] std::size_t SensorOf(std::size_t i) const {
    return static_cast<std::size_t>(sensors_[i / NumParts()]);
  }

  const renderer::Scene& scene_;
  renderer::RenderOptions options_;
  renderer::DerivativeChoice given_;
  std::vector<Direction> directions_;
  std::vector<std::vector<double>> values_;  ///< of directions, in the layout
  std::vector<int> sensors_;
  fs::path folder_;
  renderer::ParameterLayout layout_;
  renderer::Renderer renderer_;
  std::vector<std::string> names_;  ///< of all sensors, for files
  std::vector<fs::path> files_;
};

/// Those that the options name; says what is not in their derivatives.
std::vector<Direction> ChooseDirections(CommandContext& context,
                                        const Options& own,
                                        const renderer::Scene& scene,
                                        const ExperimentConfig& config) {
  std::vector<Direction> directions;
  for (const std::string& name : own.derivatives) {
    directions.push_back(NamedDirection(scene, name));
  }
  const renderer::ParameterLayout layout = UnionLayout(scene, directions);
  for (const std::string& limit :
       renderer::DerivativeLimits(scene, layout, config.derivative.form)) {
    context.log.WarnOfLimit(limit);
  }
  renderer::CheckDerivative(scene, layout, config.render);
  return directions;
}

constexpr ResultKey kResult[] = {{"files", "list", "Paths of the pictures that were written"}};

ExitStatus Run(CommandContext& context, const Options& own) {
  auto [config, experiment] = LoadTarget(context, own.stage);
  const renderer::Scene& scene = experiment.scene;
  ChangeScene(own, experiment.scene);
  const renderer::ThreadLimit limit(NumThreads(context.line, config.threads));
  std::vector<Direction> directions = ChooseDirections(context, own, scene, config);
  const fs::path folder =
      fs::absolute(own.output.empty() ? fs::path("renders") / config.name : own.output);
  Pictures pictures(scene,
                    config.render,
                    config.derivative,
                    std::move(directions),
                    ChooseSensors(scene, own.views),
                    folder);
  if (context.ranks.IsFirst()) renderer::CreateFolders(folder);

  const StopSignals signals;
  try {
    optim::Division division(&context.ranks, &signals.flag());
    division.ForEach<Rendering>(
        optim::Division::Kind::kReport,
        pictures.Count(),
        [&](std::size_t i, const auto& give) { give(pictures.Render(i, signals.flag())); },
        [&](std::size_t i, const Rendering& rendering) {
          pictures.Write(i, rendering, context.log);
        });
    if (!context.ranks.IsFirst()) return ExitStatus::kFinished;
  } catch (const renderer::Cancelled&) {
    return signals.Received().value_or(ExitStatus::kStopped);
  }
  if (own.orbit > 0) {
    context.log.Info(
        fmt::format("a film of them: ffmpeg -framerate 24 -i '{}/orbit_%03d.png' -vf "
                    "'pad=ceil(iw/2)*2:ceil(ih/2)*2' -pix_fmt yuv420p orbit.mp4",
                    folder.string()));
  }
  if (context.line.json) {
    Json files = Json::array();
    for (const fs::path& path : pictures.files()) files.push_back(path.string());
    PrintResult(context, {{"files", std::move(files)}});
  } else {
    for (const fs::path& path : pictures.files()) fmt::print("{}\n", path.string());
  }
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kRenderCommand = {"render",
                                       "Renders views, or derivative images",
                                       "CONFIG|RUN",
                                       Prepare<Options, Declare, Run>,
                                       kResult,
                                       true};

}  // namespace pathfit::app::render_command
