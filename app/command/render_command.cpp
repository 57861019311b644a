#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/stop_signals.h"
#include "app/config/experiment_config.h"
#include "app/experiment/direction.h"
#include "app/experiment/experiment.h"
#include "app/output/report_images.h"
#include "app/output/run_directory.h"
#include "app/output/signed_image.h"
#include "optim/checkpoint/checkpoint.h"
#include "renderer/core/error.h"
#include "renderer/derivative/derivative_limits.h"
#include "renderer/derivative/film_sink.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/image_file.h"
#include "renderer/renderer.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;

/// Sensors by index or name; all without a choice.
std::vector<int> ChooseSensors(const renderer::Scene& scene, const CommandLine& line) {
  const int count = static_cast<int>(scene.sensors.size());
  const std::vector<std::string>& wanted = line.views;
  std::vector<int> chosen;
  for (int i = 0; i < count; ++i) {
    const std::string& name = scene.sensors[static_cast<std::size_t>(i)].name;
    for (const std::string& w : wanted) {
      if (w == name || w == std::to_string(i) || w == "all") {
        chosen.push_back(i);
        break;
      }
    }
  }
  if (wanted.empty()) {
    for (int i = 0; i < count; ++i) chosen.push_back(i);
  } else if (chosen.empty()) {
    throw renderer::SceneError("no sensor or photo is called '" + wanted.front() + "'; there are " +
                               std::to_string(count) + ", the first is '" +
                               (count > 0 ? scene.sensors[0].name : "") + "'");
  }
  return chosen;
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
      if (layout.FirstBlock(group.kind, group.object) < 0) layout.Add(group.kind, group.object);
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
    std::copy(first,
              first + static_cast<std::int64_t>(group.num_blocks) * group.block_size,
              values.begin() + to);
  }
  return values;
}

/// Derivative images in several directions from one rendering.
class DirectionSink : public renderer::DerivativeSink {
 public:
  DirectionSink(const renderer::ParameterLayout& layout,
                const std::vector<Direction>& directions,
                const renderer::Camera& camera) {
    for (const Direction& direction : directions) {
      films_.push_back(std::make_unique<renderer::FilmSink>(
          layout, ValuesIn(layout, direction), camera.width, camera.height));
    }
  }
  void Add(std::int64_t pixel,
           std::span<const renderer::ParameterDerivative> derivatives) override {
    for (auto& film : films_) film->Add(pixel, derivatives);
  }
  [[nodiscard]] const renderer::Film& film(std::size_t i) const { return films_[i]->film(); }

 private:
  std::vector<std::unique_ptr<renderer::FilmSink>> films_;
};

/// A config, or a run whose newest state is put into its scene.
Experiment LoadTarget(const ExperimentConfig& config, const fs::path& run_root, Log& log) {
  Experiment experiment = BuildExperiment(config);
  for (const std::string& text : experiment.assumptions) log.Info(text);
  for (const std::string& text : experiment.warnings) log.Warn(text);
  if (!run_root.empty()) {
    optim::NewestCheckpoint newest = optim::ReadNewestCheckpoint(
        RunDirectory(run_root).Checkpoints(), {experiment.scene, experiment.fit.unknowns});
    for (const std::string& reason : newest.damaged) {
      log.Warn("a checkpoint is left out, and an older one rendered: " + reason);
    }
    if (!newest.state) {
      throw renderer::IoError(run_root.string() + ": the run has no checkpoint to render");
    }
    experiment.scene = std::move(newest.state->scene);
  }
  return experiment;
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

void Declare(OptionList& options, CommandLine& line) {
  using Form = OptionList::Form;
  options.ConfigOptions();
  options.Path("-o,--output", "DIR", "Where images go", line.output);
  options.List("--views", "Photos by index or name, e.g. 0,3,8; or all", line.views);
  options.Texts("--sensor", "NAME", "A sensor or photo; may be repeated", line.views);
  options.Override("--spp", "N", "Samples per pixel", "render.spp", Form::kWhole, 1);
  options.Texts("--derivative", "PARAM", "Derivative image; may be repeated", line.derivatives);
  options.Override("--terms",
                   "LIST",
                   "Of the derivative: interior,primary,direct,indirect,pixel",
                   "render.terms",
                   Form::kWords);
  options.Override(
      "--form", "FORM", "Of the derivative: image or material", "render.form", Form::kText);
  options.Check([&options, &line] {
    if (!line.views.empty() && line.views.front().starts_with("orbit:")) {
      options.Fail("--views: 'orbit:' is not supported; give indices, names or all");
    }
    if (options.Given("--views") && options.Given("--sensor")) {
      options.Fail("--views and --sensor exclude each other");
    }
    if (options.Given("--views") && line.views.size() == 1 && line.views.front() == "all") {
      line.views.clear();
    }
    for (const char* flag : {"--terms", "--form"}) {
      if (options.Given(flag) && line.derivatives.empty()) {
        options.Fail(std::string(flag) + " needs --derivative");
      }
    }
  });
}

ExitStatus Run(CommandContext& context) {
  const CommandLine& line = context.line;
  const bool is_run = fs::is_directory(line.target);
  const fs::path run_root = is_run ? OpenRunDirectory(line.target).root() : fs::path();
  const fs::path config_path = is_run ? RunDirectory(run_root).ResolvedConfig() : line.target;
  const ExperimentConfig config = LoadExperimentConfig(config_path, line.overrides);
  const renderer::ThreadLimit limit(NumThreads(line, config.threads));
  const Experiment experiment = LoadTarget(config, run_root, context.log);
  std::vector<Direction> directions;
  for (const std::string& name : line.derivatives) {
    directions.push_back(NamedDirection(experiment.scene, name));
  }
  const renderer::ParameterLayout layout = UnionLayout(experiment.scene, directions);
  for (const std::string& limit_of : renderer::DerivativeLimits(experiment.scene, layout)) {
    context.log.Warn(limit_of);
    ShowThoughQuiet(context, "not in the derivative: " + limit_of);
  }
  renderer::RenderOptions options = config.render;
  renderer::CheckDerivative(experiment.scene, layout, options);
  const std::vector<int> sensors = ChooseSensors(experiment.scene, line);
  const fs::path folder =
      fs::absolute(line.output.empty() ? fs::path("renders") / config.name : line.output);
  renderer::CreateFolders(folder);

  const StopSignals signals;
  const renderer::Renderer renderer(experiment.scene);
  const std::vector<std::string> names = ViewFolderNames([&] {
    std::vector<std::string> all;
    for (const auto& sensor : experiment.scene.sensors) all.push_back(sensor.name);
    return all;
  }());
  std::vector<fs::path> written;
  try {
    for (const int index : sensors) {
      const auto& camera = experiment.scene.sensors[static_cast<std::size_t>(index)];
      const std::string& name = names[static_cast<std::size_t>(index)];
      options.view = static_cast<std::uint64_t>(index);
      renderer::RenderStats stats;
      const renderer::RenderServices services{.cancel = &signals.flag(), .stats = &stats};
      WriteFilm(renderer.RenderPrimal(camera, options, services), folder / name, written);
      if (!directions.empty()) {
        DirectionSink sink(layout, directions, camera);
        options.with_image = false;
        renderer.RenderDerivative(camera, index, options, layout, sink, services);
        for (std::size_t i = 0; i < directions.size(); ++i) {
          WriteDerivative(sink.film(i),
                          folder / (name + "_d_" + SafeFileName(directions[i].name)),
                          context.log,
                          written);
        }
      }
      LogStats(stats, context.log);
      context.log.Info("rendered " + camera.name);
    }
  } catch (const renderer::Cancelled&) {
    return signals.Received().value_or(ExitStatus::kStopped);
  }
  for (const fs::path& path : written) std::printf("%s\n", path.c_str());
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kRenderCommand = {
    "render", "Renders views, or derivative images", "CONFIG|RUN", Declare, Run};

}  // namespace pathfit::app
