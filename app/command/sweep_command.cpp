#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "app/command/child_process.h"
#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/command/run_scene.h"
#include "app/command/stop_signals.h"
#include "app/config/experiment_config.h"
#include "app/experiment/fittable.h"
#include "app/output/comparison.h"
#include "app/output/file_lock.h"
#include "app/output/sha256.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app::sweep_command {
namespace {

namespace fs = std::filesystem;
using renderer::IoError;

constexpr std::size_t kMostRuns = 10000;

/// One of the settings that vary, and its values as they were written.
struct Axis {
  std::string key;
  std::vector<std::string> values;
};

/// One run of the sweep: a value for each axis.
struct Run {
  std::string name;  ///< of its folder
  std::vector<std::string> values;
};

struct Plan {
  std::vector<Axis> axes;
  std::vector<Run> runs;
};

/// "a,[1,2],'x,y'" at the commas outside of brackets and quotes.
std::vector<std::string> SplitValues(const std::string& text) {
  std::vector<std::string> values(1);
  int depth = 0;
  char quote = 0;
  for (const char c : text) {
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if (c == ']' || c == '}') {
      --depth;
    }
    if (c == ',' && depth == 0 && quote == 0) {
      values.emplace_back();
    } else {
      values.back() += c;
    }
  }
  return values;
}

/// Of KEY=A,B,C.
Axis ParseAxis(const std::string& word) {
  const std::size_t equals = word.find('=');
  return {word.substr(0, equals), SplitValues(word.substr(equals + 1))};
}

Axis CheckedAxis(const OptionList& options, const std::string& word) {
  if (word.find('=') == std::string::npos || word.starts_with('=')) {
    options.Fail("--vary: '" + word + "' is not KEY=A,B,C");
  }
  Axis axis = ParseAxis(word);
  std::set<std::string> before;
  for (const std::string& value : axis.values) {
    if (value.empty()) options.Fail("--vary: '" + word + "' has an empty value");
    if (!before.insert(value).second) {
      options.Fail("--vary: '" + word + "' has " + value + " twice");
    }
  }
  return axis;
}

struct Options {
  std::vector<std::string> vary;  ///< KEY=A,B,C
  int seeds = 1;
  fs::path output;
  bool list = false;  ///< prints the commands instead of running them
  int only = 0;       ///< number of one run; 0: all
};

void Declare(OptionList& options, Options& own) {
  options.Set();
  options.Seed();
  options.Threads();
  options.MaxMemory();
  options.Texts("--vary", "KEY=A,B", "A setting and its values; may be repeated", own.vary);
  options.Whole("--seeds", "Runs of each, with seeds that count up", 1, 10000, own.seeds);
  options.Path("-o,--output", "DIR", "Folder of all runs; else sweeps/NAME here", own.output);
  options.Flag("--list", "Prints a command for each run, for a job array, and runs none", own.list);
  options.Whole(
      "--only", "Runs this one of the list, from 1, and writes no table", 1, 10000, own.only);
  options.Check([&options, &own] {
    std::set<std::string> keys;
    for (const std::string& word : own.vary) {
      const std::string key = CheckedAxis(options, word).key;
      if (!keys.insert(key).second) options.Fail("--vary: " + key + " is given twice");
      if (key == "output.directory")
        options.Fail("--vary: each run has its folder below that of -o");
    }
    const bool has_seeds = own.seeds > 1;
    if (has_seeds && keys.count("seed") > 0)
      options.Fail("--seeds and --vary seed= exclude each other");
    if (keys.empty() && !has_seeds)
      options.Fail("nothing varies; give --vary KEY=A,B or --seeds N");
    if (own.list && options.Given("--only")) options.Fail("--list and --only exclude each other");
  });
}

/// Overrides of one run: what the command line says of all, then its own values.
std::vector<ConfigOverride> OverridesOf(const CommandLine& line, const Plan& plan, const Run& run) {
  std::vector<ConfigOverride> overrides = line.overrides;
  for (std::size_t i = 0; i < plan.axes.size(); ++i) {
    overrides.push_back(
        {"--vary #" + std::to_string(i + 1), plan.axes[i].key + "=" + run.values[i], true});
  }
  return overrides;
}

/// The first axis turns slowest.
Plan MakePlan(std::vector<Axis> axes) {
  std::size_t count = 1;
  for (const Axis& axis : axes) {
    if (axis.values.size() > kMostRuns / count) {
      throw UsageError("sweep", fmt::format("more than {} runs", kMostRuns));
    }
    count *= axis.values.size();
  }
  Plan plan{std::move(axes), {{}}};
  for (const Axis& axis : plan.axes) {
    std::vector<Run> longer;
    for (const Run& run : plan.runs) {
      for (const std::string& value : axis.values) {
        longer.push_back(run);
        longer.back().values.push_back(value);
      }
    }
    plan.runs = std::move(longer);
  }
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    std::string name = fmt::format("{:03}", i + 1);
    for (std::size_t a = 0; a < plan.axes.size(); ++a) {
      const std::string& key = plan.axes[a].key;
      name += "_" + key.substr(key.rfind('.') + 1) + "=" + plan.runs[i].values[a];
    }
    plan.runs[i].name = SafeFileName(name);
  }
  return plan;
}

std::string ShellQuoted(const std::string& word) {
  constexpr const char* kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./=:,+-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// The same command for one run each: it can be stopped and repeated, alone or beside the others.
std::vector<std::string> ListOf(const CommandLine& line, const Plan& plan) {
  std::string command;
  for (const std::string& word : line.arguments) {
    if (word == "--list" || word == "--json") continue;
    command += (command.empty() ? "" : " ") + ShellQuoted(word);
  }
  std::vector<std::string> list;
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    list.push_back(fmt::format("{} --only {}", command, i + 1));
  }
  return list;
}

/// What makes a sweep this one, for sweep.json.
Json PlanJson(const ExperimentConfig& config, const CommandLine& line, const Plan& plan) {
  Json json = {{"config", config.path.string()},
               {"config_sha256", Sha256Hex(config.given_text)},
               {"overrides", Json::array()},
               {"vary", Json::object()},
               {"runs", Json::array()}};
  for (const ConfigOverride& given : line.overrides) {
    // Neither changes the result.
    if (given.label != "--threads" && given.label != "--max-memory") {
      json["overrides"].push_back(given.assignment);
    }
  }
  for (const Axis& axis : plan.axes) json["vary"][axis.key] = axis.values;
  for (const Run& run : plan.runs) json["runs"].push_back(run.name);
  return json;
}

/// Begins the folder, or continues in that of the same sweep.
void OpenFolder(const fs::path& folder, const Json& plan) {
  const fs::path file = folder / "sweep.json";
  renderer::CreateFolders(folder);
  // Two sweeps may begin it at once.
  const FileLock lock(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC, LOCK_EX);
  if (fs::exists(file)) {
    if (Json::parse(renderer::ReadWholeFile(file), nullptr, false) == plan) return;
    throw UsageError("sweep",
                     folder.string() +
                         " holds another sweep (other values, or the config has changed); -o "
                         "names another folder");
  }
  if (!fs::is_empty(folder)) {
    throw UsageError("sweep", folder.string() + " is not empty; -o names another folder");
  }
  renderer::WriteFileAtomically(file, JsonText(plan) + "\n");
}

/// The program's own run of a command; its results are not shown.
ExitStatus RunProcess(const std::vector<std::string>& words, const StopSignals& signals) {
  const std::optional<int> status = RunChild({"/proc/self/exe", words, {}, false}, signals);
  return status ? static_cast<ExitStatus>(*status) : ExitStatus::kInternalError;
}

/// What has become of a run's folder: "missing", or the status of its record.
std::string StatusOf(const fs::path& folder) {
  const RunDirectory run(folder);
  return fs::exists(run.Record()) ? EffectiveStatus(ReadRunRecord(run.Record()), folder)
                                  : "missing";
}

std::string StatusIn(const fs::path& sweep, const Run& run) {
  return fs::is_directory(sweep / run.name) ? StatusOf(sweep / run.name) : "missing";
}

std::string StatusOrDamaged(const fs::path& sweep, const Run& run) {
  try {
    return StatusIn(sweep, run);
  } catch (const IoError&) {
    return "damaged";
  }
}

/// The run as compare sees it; nothing if there is none, or it cannot be read.
std::optional<ComparedRun> FiguresOf(const fs::path& sweep, const Run& run) {
  try {
    if (StatusIn(sweep, run) == "missing") return std::nullopt;
    return LoadRuns({RunDirectory(sweep / run.name)}).at(0);
  } catch (const IoError&) {
    return std::nullopt;
  }
}

/// Names of runs that ended before they had a folder, as those do that are refused.
using Refused = std::set<std::string>;

/// Begins or continues one run; warns if it is not done then.
ExitStatus DoRun(const CommandContext& context,
                 const ExperimentConfig& config,
                 const Plan& plan,
                 const Run& run,
                 const fs::path& sweep,
                 const StopSignals& signals,
                 Refused& refused) {
  const CommandLine& line = context.line;
  const fs::path folder = sweep / run.name;
  const auto fail = [&](ExitStatus with, const std::string& text) {
    context.log.Warn(folder.string() + ": " + text);
    return with;
  };
  if (StatusOrDamaged(sweep, run) == "finished") {
    const std::vector<std::string> changed =
        ChangedInputs(ReadRunRecord(RunDirectory(folder).Record()));
    if (!changed.empty()) {
      return fail(ExitStatus::kInput,
                  fmt::format("is of other files: {} has changed since; -o names another folder",
                              changed.front()));
    }
    context.log.Info("done before");
    return ExitStatus::kFinished;
  }
  // Without O_CLOEXEC: the run keeps the lock if only this process is killed.
  const FileLock lock(sweep / ("." + run.name + ".lock"), O_RDWR | O_CREAT, LOCK_EX | LOCK_NB);
  std::string status = "running";
  try {
    if (!lock.IsTaken()) status = StatusIn(sweep, run);
  } catch (const IoError& error) {
    return fail(ExitStatus::kInput, std::string(error.what()) + "; remove the folder and repeat");
  }
  if (status == "running") {
    return fail(ExitStatus::kInput, "is being run by another process; left out here");
  }
  if (status == "finished") return ExitStatus::kFinished;  // by another process, just now
  std::vector<std::string> words = {line.arguments.front()};
  // A run that failed begins anew: its input may have been mended.
  if (status == "stopped" || status == "killed") {
    words.insert(words.end(), {"resume", folder.string()});
  } else {
    fs::remove_all(folder);  // of this sweep, and without a result
    words.insert(words.end(), {"fit", config.path.string(), "-o", folder.string()});
    for (const ConfigOverride& given : OverridesOf(line, plan, run)) {
      words.insert(words.end(), {"--set", given.assignment});
    }
  }
  if (line.threads) words.insert(words.end(), {"--threads", std::to_string(*line.threads)});
  for (const std::string& option : MessageOptions(line)) words.push_back(option);
  const ExitStatus result = RunProcess(words, signals);
  if (result == ExitStatus::kFinished && StatusOrDamaged(sweep, run) != "finished") {
    return fail(ExitStatus::kInput, "the run ended, but its result is not there");
  }
  const bool stopped =
      signals.Received() || result == ExitStatus::kStopped || result == ExitStatus::kInterrupted;
  if (result == ExitStatus::kFinished || stopped) return result;
  if (StatusOrDamaged(sweep, run) == "missing") refused.insert(run.name);
  const bool broken = words[1] == "resume" && result == ExitStatus::kInput;
  return fail(result,
              fmt::format("ended with status {}{}",
                          static_cast<int>(result),
                          broken ? "; remove the folder and repeat" : ""));
}

/// One row for each run: its values, its status and what compare would say of it.
Json TableOf(const Plan& plan, const fs::path& sweep, const Refused& refused) {
  Json rows = Json::array();
  for (const Run& run : plan.runs) {
    const std::string status = refused.contains(run.name) ? "failed" : StatusOrDamaged(sweep, run);
    Json row = {{"run", run.name}, {"status", status}};
    for (std::size_t i = 0; i < plan.axes.size(); ++i) row[plan.axes[i].key] = run.values[i];
    const std::optional<ComparedRun> figures = FiguresOf(sweep, run);
    for (const FigureColumn& column : FigureColumns())
      row[column.key] = figures ? ToJson(column.value(*figures)) : Json();
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string CsvOf(const Json& rows) {
  std::string csv;
  for (const auto& [key, value] : rows[0].items()) csv += (csv.empty() ? "" : ",") + CsvCell(key);
  csv += "\n";
  for (const Json& row : rows) {
    std::string line;
    for (const auto& [key, value] : row.items()) {
      line += value.is_null()     ? ","
              : value.is_string() ? CsvCell(value.get<std::string>()) + ","
                                  : CsvCell(value.get<double>()) + ",";
    }
    line.back() = '\n';
    csv += line;
  }
  return csv;
}

std::string TextOf(const Json& rows, const Plan& plan) {
  std::vector<std::vector<std::string>> table = {{"Run"}};
  for (const Axis& axis : plan.axes) table[0].push_back(axis.key);
  table[0].emplace_back("Status");
  for (const FigureColumn& column : FigureColumns()) table[0].emplace_back(column.heading);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::vector<std::string>& line = table.emplace_back();
    line.push_back(std::to_string(i + 1));
    for (const std::string& value : plan.runs[i].values) line.push_back(value);
    line.push_back(rows[i]["status"].get<std::string>());
    for (const FigureColumn& column : FigureColumns()) {
      const Json& value = rows[i][column.key];
      line.push_back(value.is_number() ? column.text(value.get<double>()) : "-");
    }
  }
  return AlignedTable(table);
}

/// Means of what is finished over the seeds, which turn fastest if they are the last axis; empty
/// otherwise.
std::string SeedsText(const Json& rows, const Plan& plan) {
  const Axis& seeds = plan.axes.back();
  const std::size_t count = seeds.values.size();
  if (seeds.key != "seed" || count < 2) return "";
  std::vector<std::vector<std::string>> table = {{"Runs"}};
  for (const Axis& axis : plan.axes) {
    if (&axis != &seeds) table[0].push_back(axis.key);
  }
  for (const FigureColumn& column : FigureColumns()) table[0].emplace_back(column.heading);
  for (std::size_t first = 0; first < rows.size(); first += count) {
    std::size_t finished = 0;
    for (std::size_t i = first; i < first + count; ++i) finished += rows[i]["status"] == "finished";
    auto& line = table.emplace_back(std::vector{fmt::format("{}-{}", first + 1, first + count)});
    if (finished < count) line[0] += fmt::format(" ({} of {})", finished, count);
    const std::vector<std::string>& values = plan.runs[first].values;
    line.insert(line.end(), values.begin(), values.end() - 1);
    for (const FigureColumn& column : FigureColumns()) {
      double n = 0.0, sum = 0.0, squares = 0.0;
      for (std::size_t i = first; i < first + count; ++i) {
        const Json& value = rows[i][column.key];
        if (rows[i]["status"] != "finished" || !value.is_number()) continue;
        // Welford's recurrence.
        const double step = value.get<double>() - (n > 0.0 ? sum / n : 0.0);
        sum += value.get<double>();
        n += 1.0;
        squares += step * (value.get<double>() - sum / n);
      }
      line.push_back(n == 0.0   ? "-"
                     : n == 1.0 ? column.text(sum)
                                : column.text(sum / n) + " ± " +
                                      column.text(std::sqrt(squares / (n - 1.0))));
    }
  }
  return "\nMeans over seeds, with standard deviations:\n" + AlignedTable(table);
}

constexpr ResultKey kResult[] = {
    {"folder", "text", "Of all runs"},
    {"list", "list", "With --list: a command for each run; else empty"},
    {"runs",
     "list",
     "Maps of run, status, the settings that vary and the figures of compare; null where a run has "
     "none"},
    {"files", "list", "Tables that were written"}};

void PrintList(const CommandContext& context, const fs::path& folder, const Plan& plan) {
  const std::vector<std::string> list = ListOf(context.line, plan);
  if (context.line.json) {
    PrintResult(context,
                {{"folder", folder.string()},
                 {"list", list},
                 {"runs", Json::array()},
                 {"files", Json::array()}});
    return;
  }
  for (const std::string& command : list) fmt::print("{}\n", command);
  context.log.Info(
      "one run of a job array: sh -c \"$(sed -n \"${SLURM_ARRAY_TASK_ID}p\" LIST)\"; the table: "
      "the "
      "same command without --list once all are done");
}

void WriteTable(const CommandContext& context,
                const fs::path& folder,
                const Plan& plan,
                const Refused& refused) {
  const Json rows = TableOf(plan, folder, refused);
  const fs::path csv = folder / "table.csv";
  const fs::path json = folder / "table.json";
  renderer::WriteFileAtomically(csv, CsvOf(rows));
  renderer::WriteFileAtomically(json, JsonText(rows) + "\n");
  if (context.line.json) {
    PrintResult(context,
                {{"folder", folder.string()},
                 {"list", Json::array()},
                 {"runs", rows},
                 {"files", Json::array({csv.string(), json.string()})}});
  } else {
    fmt::print("{}{}", TextOf(rows, plan), SeedsText(rows, plan));
  }
  context.log.Info("tables: " + csv.string() + ", " + json.string());
}

/// All runs, none of which starts unless all can.
Plan CheckedPlan(const CommandLine& line, const Options& own, const ExperimentConfig& config) {
  RequireFittable(config, "");
  std::vector<Axis> axes;
  for (const std::string& word : own.vary) axes.push_back(ParseAxis(word));
  if (own.seeds > 1) {
    Axis& seeds = axes.emplace_back(Axis{"seed", {}});
    for (int i = 0; i < own.seeds; ++i) {
      seeds.values.push_back(std::to_string(config.render.seed + static_cast<std::uint64_t>(i)));
    }
  }
  Plan plan = MakePlan(std::move(axes));
  for (const Run& run : plan.runs) {
    RequireFittable(LoadExperimentConfig(line.target, OverridesOf(line, plan, run)), "");
  }
  return plan;
}

/// That of all runs.
fs::path FolderOf(const Options& own, const ExperimentConfig& config) {
  fs::path folder = fs::absolute(own.output.empty() ? fs::path("sweeps") / config.name : own.output)
                        .lexically_normal();
  for (const char* pattern : {"{name}", "{timestamp}", "${"}) {
    // The runs would replace it, each for itself.
    if (folder.string().find(pattern) != std::string::npos) {
      throw UsageError("sweep", folder.string() + ": a sweep's folder cannot hold " + pattern);
    }
  }
  return folder;
}

ExitStatus RunSweep(CommandContext& context, const Options& own) {
  const CommandLine& line = context.line;
  const ExperimentConfig config = LoadExperimentConfig(line.target, line.overrides);
  const Plan plan = CheckedPlan(line, own, config);
  const fs::path folder = FolderOf(own, config);
  if (own.list) {
    PrintList(context, folder, plan);
    return ExitStatus::kFinished;
  }
  if (own.only > static_cast<int>(plan.runs.size())) {
    throw UsageError("sweep", fmt::format("--only: there are {} runs", plan.runs.size()));
  }
  OpenFolder(folder, PlanJson(config, line, plan));

  const StopSignals signals;
  Refused refused;
  ExitStatus worst = ExitStatus::kFinished;
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    if (own.only > 0 && own.only != static_cast<int>(i) + 1) continue;
    const Run& run = plan.runs[i];
    context.log.Info(fmt::format("run {} of {}: {}", i + 1, plan.runs.size(), run.name));
    const ExitStatus status = DoRun(context, config, plan, run, folder, signals, refused);
    if (signals.Received() || status == ExitStatus::kStopped ||
        status == ExitStatus::kInterrupted) {
      context.log.Warn("stopped; the same command goes on where it was");
      return signals.Received().value_or(status);
    }
    if (worst == ExitStatus::kFinished) worst = status;
  }
  if (own.only > 0) {
    const Run& run = plan.runs[static_cast<std::size_t>(own.only) - 1];
    if (line.json) {
      PrintResult(context,
                  {{"folder", folder.string()},
                   {"list", Json::array()},
                   {"runs", Json::array({TableOf({plan.axes, {run}}, folder, refused)[0]})},
                   {"files", Json::array()}});
    } else {
      fmt::print("{}\n", (folder / run.name).string());
    }
  } else {
    WriteTable(context, folder, plan, refused);
  }
  return worst;
}

}  // namespace

extern const Command kSweepCommand = {
    "sweep",
    "Fits over values of settings and seeds, one after the other, and makes one table",
    "CONFIG",
    Prepare<Options, Declare, RunSweep>,
    kResult};

}  // namespace pathfit::app::sweep_command
