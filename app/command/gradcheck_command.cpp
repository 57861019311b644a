#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <set>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/command/stop_signals.h"
#include "app/config/experiment_config.h"
#include "app/config/nearest_name.h"
#include "app/experiment/direction.h"
#include "app/experiment/experiment.h"
#include "app/output/fields.h"
#include "app/output/run_directory.h"
#include "app/output/signed_image.h"
#include "optim/diagnostics/gradient_check.h"
#include "optim/parameter/promotion.h"
#include "optim/ranks/division.h"
#include "optim/ranks/film_stream.h"
#include "renderer/core/error.h"
#include "renderer/derivative/derivative_limits.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/image_file.h"

namespace pathfit::app::gradcheck_command {
namespace {

namespace fs = std::filesystem;

constexpr int kTile = 4;

/// Directions to check, together all of the named parameters: those of the command line or config,
/// where a glob stands for matching unknowns; all unknowns without any.
std::vector<Direction> ChooseDirections(const Experiment& experiment,
                                        const std::vector<std::string>& params) {
  std::vector<std::string> names;
  for (const std::string& param : params.empty() ? std::vector<std::string>{"*"} : params) {
    if (param.find_first_of("*?") == std::string::npos) {
      names.push_back(param);
      continue;
    }
    const std::size_t before = names.size();
    for (const optim::UnknownSpec& unknown : experiment.fit.unknowns) {
      if (optim::IsReplaced(experiment.scene, unknown, experiment.fit.unknowns)) continue;
      if (MatchesGlob(param, unknown.name)) names.push_back(unknown.name);
    }
    if (names.size() == before) {
      throw renderer::SceneError("no unknown matches '" + param + "'");
    }
  }
  std::vector<Direction> directions;
  for (const std::string& name : names) {
    for (const std::string& direction : DirectionNames(experiment.scene, name)) {
      directions.push_back(ParseDirection(experiment.scene, direction, FieldDirection::kRandom));
    }
  }
  return directions;
}

/// Estimators and boundary budgets of `render`, samples of `gradcheck`.
optim::GradientCheckOptions OptionsOf(const ExperimentConfig& config) {
  optim::GradientCheckOptions options = config.gradcheck.check;
  options.render = config.render;
  options.render.spp = config.gradcheck.check.render.spp;
  options.given = config.derivative;
  options.difference_spp = 2 * options.render.spp;
  return options;
}

/// Mean images of a check by what they show.
using Pictures = std::vector<std::pair<std::string, renderer::Film>>;

Pictures PicturesOf(const optim::GradientCheckResult& result) {
  Pictures pictures;
  for (const auto& [name, term] : renderer::kDerivativeTerms) {
    if (!result[term].empty()) {
      pictures.emplace_back(name, optim::MeanFilm(result[term]));
    }
  }
  pictures.emplace_back("derivative", optim::MeanFilm(optim::Estimates(result)));
  pictures.emplace_back("difference", optim::MeanFilm(result.difference));
  return pictures;
}

void WriteImages(const Pictures& pictures, const fs::path& stem) {
  if (pictures.empty()) return;
  const double scale = SignedScale(pictures.back().second);
  for (const auto& [kind, film] : pictures) {
    renderer::WriteExr(stem.string() + "_" + kind + ".exr", renderer::ColorImage(film));
    renderer::WritePng8(stem.string() + "_" + kind + ".png", SignedImage(film, scale));
  }
}

renderer::Rgba ImageSum(const std::vector<renderer::Film>& films) {
  renderer::Rgba sum;
  for (const renderer::Rgba& p : optim::MeanFilm(films).pixels) sum += p;
  return sum;
}

/// Sum over the image, mean and standard error over replicates.
struct TermSum {
  renderer::Rgba mean, error;
};
TermSum SumOf(const std::vector<renderer::Film>& films) {
  TermSum sum;
  const auto n = static_cast<double>(films.size());
  std::vector<renderer::Rgba> sums;
  for (const renderer::Film& film : films) {
    sums.push_back(ImageSum({film}));
    sum.mean += sums.back() * (1.0 / n);
  }
  for (int c = 0; c < 4; ++c) {
    double square = 0.0;
    for (const renderer::Rgba& s : sums) square += (s[c] - sum.mean[c]) * (s[c] - sum.mean[c]);
    sum.error[c] = n > 1.0 ? std::sqrt(square / (n * (n - 1.0))) : 0.0;
  }
  return sum;
}

struct Row {
  std::string name, sensor;
  optim::GradientComparison tiles, whole;
  std::vector<std::pair<std::string, TermSum>> terms;  ///< those that were run
  TermSum derivative, difference;
  bool passed = false;
  std::string not_checked;  ///< why there is nothing but the names

  static void VisitParts(auto& row, const auto& visit) {
    visit(row.name);
    visit(row.sensor);
    visit(row.tiles);
    visit(row.whole);
    visit(row.terms);
    visit(row.derivative);
    visit(row.difference);
    visit(row.passed);
    visit(row.not_checked);
  }
};

/// Noise alone has a ratio of about 1.
constexpr double kLeastSignalToNoise = 1.5;

bool Drowns(const optim::GradientComparison& comparison) {
  return comparison.signal_to_noise < kLeastSignalToNoise;
}
/// At half the step the difference is another: it is no measure of a derivative.
bool HasTooLargeStep(const optim::GradientComparison& comparison) {
  constexpr double kMostOfTheErrorBars = 0.7;
  return Drowns(comparison) &&
         comparison.truncation * comparison.signal_to_noise > kMostOfTheErrorBars;
}

void CompareInto(Row& row, const optim::GradientCheckResult& result, double sigma) {
  row.tiles = optim::Compare(result, kTile, sigma);
  row.whole = optim::Compare(result, 0, sigma);
  row.passed = (row.tiles.z_max <= row.tiles.z_limit && row.whole.z_max <= row.whole.z_limit) ||
               HasTooLargeStep(row.tiles);
}

void AddSums(const optim::GradientCheckResult& result, Row& row) {
  row.derivative = SumOf(optim::Estimates(result));
  row.difference = SumOf(result.difference);
  for (const auto& [name, term] : renderer::kDerivativeTerms) {
    if (!result[term].empty()) row.terms.emplace_back(name, SumOf(result[term]));
  }
}

struct CheckedRow {
  Row row;
  Pictures pictures;  ///< none without an output folder

  static void VisitParts(auto& checked, const auto& visit) {
    visit(checked.row);
    visit(checked.pictures);
  }
};

Json ToJson(const Row& row) {
  if (!row.not_checked.empty()) {
    return {{"parameter", row.name},
            {"sensor", row.sensor},
            {"passed", false},
            {"not_checked", row.not_checked}};
  }
  const auto rgba = [](const renderer::Rgba& c) { return Json{c.r, c.g, c.b, c.a}; };
  const auto sum = [&](const TermSum& s) {
    return Json{{"mean", rgba(s.mean)}, {"standard_error", rgba(s.error)}};
  };
  Json terms = Json::object();
  for (const auto& [name, value] : row.terms) terms[name] = sum(value);
  return {{"parameter", row.name},
          {"sensor", row.sensor},
          {"passed", row.passed},
          {"tiles", row.tiles.count},
          {"z_rms", row.tiles.z_rms},
          {"z_max", row.tiles.z_max},
          {"z_limit", row.tiles.z_limit},
          {"z_sum_max", row.whole.z_max},
          {"z_sum_limit", row.whole.z_limit},
          {"signal_to_noise", row.tiles.signal_to_noise},
          {"truncation", row.tiles.truncation},
          {"sum_of_terms", terms},
          {"sum_derivative", sum(row.derivative)},
          {"sum_difference", sum(row.difference)}};
}

/// A difference that drowns in its noise, or in its step's own error, agrees with anything.
bool IsInconclusive(const Row& row) {
  return row.passed && row.not_checked.empty() && Drowns(row.tiles);
}

const char* VerdictOf(const Row& row) {
  if (!row.not_checked.empty()) return "NOT CHECKED";
  if (!row.passed) return "DIFFERS";
  return IsInconclusive(row) ? "inconclusive" : "agrees";
}

/// The channel of a row that the table shows: of red, green and blue the one that changes most, or
/// the coverage where no colour changes. Green goes first where all are alike.
int ChannelOf(const Row& row) {
  const auto size = [&](int c) {
    return std::max(std::abs(row.difference.mean[c]), std::abs(row.derivative.mean[c]));
  };
  int most = 1;
  for (const int c : {0, 2}) {
    if (size(c) > size(most)) most = c;
  }
  return size(most) > 0.0 ? most : 3;
}

/// One line per parameter with the verdict, one per term below it.
void PrintTable(const std::vector<Row>& rows) {
  constexpr std::array<const char*, 4> kChannels = {"red", "green", "blue", "cover"};
  fmt::print(
      "{:<28} {:<12} {:<5} {:>11} {:>8} {:>11} {:>8} {:>6} {:>6} {:>6} {:>6} {:>8}  result\n",
      "parameter",
      "sensor",
      "sum",
      "difference",
      "+-",
      "derivative",
      "+-",
      "z sum",
      "z rms",
      "z max",
      "limit",
      "signal/n");
  for (const Row& r : rows) {
    if (!r.not_checked.empty()) {
      fmt::print("{:<28} {:<12} NOT CHECKED: {}\n", r.name, r.sensor, r.not_checked);
      continue;
    }
    const int c = ChannelOf(r);
    fmt::print(
        "{:<28} {:<12} {:<5} {:>11.5g} {:>8.2g} {:>11.5g} {:>8.2g} {:>6.2f} {:>6.2f} {:>6.2f} "
        "{:>6.2f} "
        "{:>8.3g}  {}\n",
        r.name,
        r.sensor,
        kChannels[static_cast<std::size_t>(c)],
        r.difference.mean[c],
        r.difference.error[c],
        r.derivative.mean[c],
        r.derivative.error[c],
        r.whole.z_max,
        r.tiles.z_rms,
        r.tiles.z_max,
        r.tiles.z_limit,
        r.tiles.signal_to_noise,
        VerdictOf(r));
    for (const auto& [name, sum] : r.terms) {
      fmt::print("{:<28} {:>39} {:>11.5g} {:>8.2g}\n", "", name, sum.mean[c], sum.error[c]);
    }
  }
  fmt::print(
      "Sums over the image of the channel named, which changes most: the finite difference, the "
      "derivative and\nits terms. z sum: of the whole image; the others over tiles of {0} x {0} "
      "pixels; both over colours and\ncoverage.\n",
      kTile);
}

struct Options {
  fs::path output;
};

void Declare(OptionList& options, Options& own) {
  using Form = OptionList::Form;
  options.Set();
  options.Seed();
  options.Threads();
  options.Path("-o,--output", "DIR", "Where images and the table go", own.output);
  options.Override("--form", "image|material", "Of the derivative", "render.form", Form::kWord);
  options.Override("--spp", "N", "Samples per pixel", "gradcheck.spp", Form::kWhole, 1);
  options.Override(
      "--replicates", "N", "Independent renderings", "gradcheck.replicates", Form::kWhole, 2);
  options.Override("--step", "X", "Of the finite difference", "gradcheck.step", Form::kPositive);
  options.Override(
      "--sigma", "X", "Largest difference in standard errors", "gradcheck.sigma", Form::kPositive);
  options.Override(
      "--params", "GLOB", "Which parameters; may be repeated", "gradcheck.params", Form::kTexts);
}

constexpr ResultKey kResult[] = {
    {"passed", "boolean", "Whether all agree"},
    {"rows",
     "list",
     "Maps by parameter and sensor: verdict (agrees, inconclusive, DIFFERS, NOT CHECKED), passed, "
     "z_rms, z_max, z_limit, z_sum_max, z_sum_limit, "
     "signal_to_noise, truncation (what the step's own error adds to the error bars, over the "
     "difference; only where they would differ without), sums of the derivative, its terms and the "
     "difference; or not_checked"}};

/// Says what is not in the derivatives, once.
void WarnOfLimits(CommandContext& context,
                  const renderer::Scene& scene,
                  const std::vector<Direction>& directions,
                  std::optional<renderer::DerivativeForm> form) {
  std::set<std::string> limits;
  for (const Direction& direction : directions) {
    for (const std::string& text : renderer::DerivativeLimits(scene, direction.layout, form)) {
      if (limits.insert(text).second) context.log.WarnOfLimit(text);
    }
  }
}

/// One direction as one sensor sees it.
CheckedRow CheckRow(const renderer::Scene& scene,
                    std::size_t sensor,
                    const Direction& direction,
                    const GradcheckConfig& config,
                    const optim::GradientCheckOptions& options,
                    bool with_pictures,
                    const renderer::CancelFlag& cancel) {
  const renderer::Camera& camera = scene.sensors[sensor];
  CheckedRow checked;
  checked.row.name = direction.name;
  checked.row.sensor = camera.name;
  optim::GradientCheckOptions own = options;
  if (!own.given->form) {
    own.given->form = renderer::DefaultForm(scene, direction.layout);  // as in fits
  }
  try {
    const auto index = static_cast<int>(sensor);
    optim::GradientCheckResult result = optim::CheckGradient(
        scene, camera, index, direction.layout, direction.values, own, &cancel);
    CompareInto(checked.row, result, config.sigma);
    if (!checked.row.passed) {  // of the derivative's doing, or of the step's?
      optim::AddHalvedDifference(
          scene, camera, index, direction.layout, direction.values, own, result, &cancel);
      CompareInto(checked.row, result, config.sigma);
    }
    AddSums(result, checked.row);
    if (with_pictures) checked.pictures = PicturesOf(result);
  } catch (const renderer::SceneError& error) {
    checked.row.not_checked = error.what();
  }
  return checked;
}

/// The verdict, on standard output.
ExitStatus Conclude(CommandContext& context, const std::vector<Row>& rows) {
  const bool passed = std::ranges::all_of(rows, [](const Row& r) { return r.passed; });
  const auto warn = [&](std::ptrdiff_t count, const char* why) {
    if (count > 0) {
      context.log.Warn(
          fmt::format("{} of {} comparisons are inconclusive: {}", count, rows.size(), why));
    }
  };
  const auto too_large = std::ranges::count_if(
      rows, [](const Row& r) { return IsInconclusive(r) && HasTooLargeStep(r.tiles); });
  warn(std::ranges::count_if(rows, IsInconclusive) - too_large,
       "the finite difference drowns in its noise; raise --spp, --replicates or --step");
  warn(too_large,
       "at half the step the finite difference is another; lower --step, and raise --spp or "
       "--replicates");
  if (context.line.json) {
    Json list = Json::array();
    for (const Row& row : rows) {
      list.push_back(ToJson(row));
      list.back()["verdict"] = VerdictOf(row);
    }
    PrintResult(context, {{"passed", passed}, {"rows", std::move(list)}});
  } else {
    PrintTable(rows);
  }
  return passed ? ExitStatus::kFinished : ExitStatus::kCheckFailed;
}

ExitStatus Run(CommandContext& context, const Options& own) {
  const CommandLine& line = context.line;
  const ExperimentConfig config = LoadExperimentConfig(line.target, line.overrides);
  if (config.gradcheck.params.empty() && config.fit.unknowns.empty()) {
    throw ConfigError(
        {config.path.string(), {}, {}},
        {{{}, "unknowns", "nothing to check: give --params, gradcheck.params or unknowns"}});
  }
  const renderer::ThreadLimit limit(NumThreads(line, config.threads));
  const Experiment experiment = BuildExperiment(config, context.ranks);
  for (const std::string& text : experiment.assumptions) context.log.Info(text);
  for (const std::string& text : experiment.warnings) context.log.Warn(text);
  const renderer::Scene& scene = experiment.scene;
  const std::vector<Direction> directions = ChooseDirections(experiment, config.gradcheck.params);
  WarnOfLimits(context, scene, directions, config.derivative.form);
  const StopSignals signals;
  const optim::GradientCheckOptions options = OptionsOf(config);
  const bool has_output = !own.output.empty();
  if (has_output && context.ranks.IsFirst()) renderer::CreateFolders(own.output);

  std::vector<Row> rows;
  const auto check = [&](std::size_t i, const auto& give) {
    give(CheckRow(scene,
                  i / directions.size(),
                  directions[i % directions.size()],
                  config.gradcheck,
                  options,
                  has_output,
                  signals.flag()));
  };
  const auto take = [&](std::size_t, const CheckedRow& checked) {
    const Row& row = checked.row;
    WriteImages(checked.pictures, own.output / SafeFileName(row.sensor + "_" + row.name));
    context.log.Info("checked " + row.name + " as seen by " + row.sensor);
    rows.push_back(row);
  };
  try {
    optim::Division division(&context.ranks, &signals.flag());
    division.ForEach<CheckedRow>(
        optim::Division::Kind::kReport, scene.sensors.size() * directions.size(), check, take);
  } catch (const renderer::Cancelled&) {
    if (!rows.empty() && !line.json) PrintTable(rows);  // all that was checked, without a verdict
    return signals.Received().value_or(ExitStatus::kStopped);
  }
  return context.ranks.IsFirst() ? Conclude(context, rows) : ExitStatus::kFinished;
}

}  // namespace

extern const Command kGradcheckCommand = {
    "gradcheck",
    "Compares derivatives with finite differences; status 7 if they disagree",
    "CONFIG",
    Prepare<Options, Declare, Run>,
    kResult,
    true};

}  // namespace pathfit::app::gradcheck_command
