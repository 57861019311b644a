#include <cmath>
#include <cstdio>
#include <memory>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/command/run_scene.h"
#include "app/command/stop_signals.h"
#include "app/config/experiment_config.h"
#include "app/experiment/experiment.h"
#include "app/experiment/fittable.h"
#include "app/experiment/start_check.h"
#include "app/output/export_result.h"
#include "app/output/file_lock.h"
#include "app/output/fit_recorder.h"
#include "app/output/parameter_table.h"
#include "app/output/report.h"
#include "app/output/sha256.h"
#include "optim/checkpoint/checkpoint.h"
#include "optim/ranks/ranks.h"
#include "optim/round/fit.h"
#include "optim/round/memory_forecast.h"
#include "optim/round/stage_plan.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/disk_full_error.h"

namespace pathfit::app::fit_command {
namespace {

namespace fs = std::filesystem;

/// Of fit; resume has the first alone.
struct Options {
  double time_limit_s = 0.0;  ///< 0: none
  std::string stop_after;     ///< name of a stage; empty: none
};

struct Ending {
  RunStatus status;
  std::string reason;
  ExitStatus exit;
};

Ending EndingOf(optim::FitStatus status, const StopSignals& signals, const RunDirectory& run) {
  const std::string how = "; continue with: pathfit resume " + run.root().string();
  if (status == optim::FitStatus::kFinished) {
    return {RunStatus::kFinished, "all stages done", ExitStatus::kFinished};
  }
  if (status == optim::FitStatus::kStageReached) {
    return {RunStatus::kFinished, "stopped after the requested stage", ExitStatus::kFinished};
  }
  if (status == optim::FitStatus::kTimeLimit) {
    return {RunStatus::kStopped, "time limit reached" + how, ExitStatus::kStopped};
  }
  const ExitStatus exit = signals.Received().value_or(ExitStatus::kStopped);
  return {RunStatus::kStopped,
          (exit == ExitStatus::kInterrupted ? "interrupted" : "terminated") + how,
          exit};
}

void WriteResults(const ExperimentConfig& config,
                  const Experiment& experiment,
                  const RunDirectory& run,
                  const optim::FitResult& result,
                  FitRecorder& recorder) {
  recorder.RecordScenes(experiment.fit, experiment.scene, result.scene, result.standard_errors);
  std::vector<ExportedView> views = ExportedViews(experiment, config);
  for (std::size_t i = 0; i < views.size(); ++i) {
    views[i].gain_error = recorder.history().gain_errors[i];
  }
  ExportResult(run.Result(),
               result.scene,
               views,
               recorder.history().parameters,
               experiment.observations.metres_per_unit);
  WriteTexelSights(run.Result(), result.scene, experiment.fit, experiment.observations);
  WriteTexelErrors(run.Result(), result.scene, experiment.fit, result.standard_errors);
}

/// Runs or continues a fit in its directory, with everything it leaves there.
ExitStatus RunInDirectory(CommandContext& context,
                          const Options& own,
                          const ExperimentConfig& config,
                          Experiment& experiment,
                          const RunDirectory& run,
                          RunRecordFile& record,
                          std::optional<optim::FitState> resume) {
  const StopSignals signals;
  const int resume_step = resume ? resume->step : 0;
  Progress progress(context.terminal);
  progress.Expect(optim::PlanStages(experiment.scene, experiment.observations, experiment.fit));
  const std::string last_stage =
      own.stop_after.empty() ? config.fit.stages.back().name : own.stop_after;
  FitRecorder recorder(run,
                       experiment.observations,
                       record,
                       context.log,
                       progress,
                       {.report = config.output.report,
                        .only_pictures_of = config.output.images_every_stage ? "" : last_stage},
                       resume_step);
  experiment.fit.time_limit_s = own.time_limit_s;
  optim::FitControls controls;
  controls.cancel = &signals.flag();
  controls.ranks = &context.ranks;
  controls.checkpoint_folder = run.Checkpoints();
  controls.resume = std::move(resume);
  controls.stop_after = own.stop_after;
  try {
    const optim::FitResult result = optim::RunFit(
        experiment.scene, experiment.observations, experiment.fit, recorder, controls);
    progress.Finish();
    WriteResults(config, experiment, run, result, recorder);
    record.SetTimes(result.wall_s, 0.0);
    if (result.gauge) {
      record.SetGauge(result.gauge);
      context.log.Write(MissesItsRule(*result.gauge) ? LogLevel::kWarn : LogLevel::kInfo,
                        GaugeSentence(*result.gauge));
    }
    const Ending ending = EndingOf(result.status, signals, run);
    const std::string doubt = DoubtWords(recorder.history());
    if (ending.status == RunStatus::kFinished) {
      if (!doubt.empty()) context.log.Warn(doubt);
      for (const std::string& text : DerivedWarnings(recorder.history())) context.log.Info(text);
    }
    recorder.Finish(ending.status, ending.reason, static_cast<int>(ending.exit));
    std::string words = ResultWords(recorder.history());
    if (!words.empty()) words = "; " + words;
    if (config.output.report) words += "; report: " + run.Report().string();
    context.log.Info(fmt::format(
        "{}; {} rounds in {}{}", ending.reason, result.rounds, DurationText(result.wall_s), words));
    return ending.exit;
  } catch (const renderer::DiskFullError& e) {
    progress.Finish();
    const std::string words = std::string(e.what()) +
                              "; make room, then continue with: pathfit resume " +
                              run.root().string();
    try {
      recorder.Finish(RunStatus::kStopped, words, static_cast<int>(ExitStatus::kStopped));
    } catch (const renderer::IoError&) {
      context.log.Warn("run.json still says that the run goes on: there is no room for more");
    }
    context.log.Error(words);
    return ExitStatus::kStopped;
  } catch (const std::exception& e) {
    progress.Finish();
    try {
      recorder.Finish(RunStatus::kFailed, e.what(), static_cast<int>(StatusOfException(e)));
    } catch (const std::exception& second) {
      context.log.Warn(std::string("run.json still says that the run goes on: ") + second.what());
    }
    throw;
  }
}

/// Renders what the first rank asks for.
ExitStatus Follow(CommandContext& context, const Experiment& experiment) {
  const StopSignals signals;
  optim::SilentObserver observer;
  optim::FitControls controls;
  controls.cancel = &signals.flag();
  controls.ranks = &context.ranks;
  optim::RunFit(experiment.scene, experiment.observations, experiment.fit, observer, controls);
  return ExitStatus::kFinished;
}

constexpr ResultKey kResult[] = {
    {"run", "text", "The run directory"},
    {"record",
     "map",
     "What run.json holds: status, reason, stages with their figures, inputs ..."}};

void PrintRun(const CommandContext& context, const RunDirectory& run) {
  if (context.line.json) {
    PrintResult(context,
                {{"run", run.root().string()}, {"record", ToJson(ReadRunRecord(run.Record()))}});
  } else {
    std::printf("%s\n", run.root().c_str());
  }
  std::fflush(stdout);
}

void DeclareTimeLimit(OptionList& options, Options& own) {
  options.Duration("--time-limit", "Stops with a checkpoint, e.g. 2h, 90m", own.time_limit_s);
}

void DeclareFit(OptionList& options, Options& own) {
  options.Set();
  options.Seed();
  options.Threads();
  options.MaxMemory();
  options.Override(
      "-o,--output", "DIR", "Run directory", "output.directory", OptionList::Form::kPath);
  DeclareTimeLimit(options, own);
  options.Text("--stop-after", "STAGE", "Ends after this stage", own.stop_after);
}

/// Held while a process works in the directory; it ends with the process.
std::unique_ptr<FileLock> LockRun(const RunDirectory& run) {
  auto lock =
      std::make_unique<FileLock>(run.root(), O_RDONLY | O_DIRECTORY | O_CLOEXEC, LOCK_EX | LOCK_NB);
  if (lock->IsTaken()) {
    throw renderer::IoError(run.root().string() + ": is being run by another process");
  }
  return lock;
}

void DeclareResume(OptionList& options, Options& own) {
  options.Threads();
  options.MaxMemory();
  DeclareTimeLimit(options, own);
}

/// Refuses what would pass the limit, if there is one, as `check` does. That takes as long as some
/// rounds: of a limit that nobody has set only where what is loaded is no small part of it. Rounds
/// look at it all the same.
void RequireMemoryOf(const ExperimentConfig& config, const Experiment& experiment) {
  constexpr double kSmallPart = 1.0 / 16.0;
  const double limit = experiment.fit.max_memory_bytes;
  if (limit <= 0.0 || std::isinf(limit)) return;
  const bool is_set = config.max_memory_bytes > 0.0;
  if (!is_set && optim::LoadedMemory().bytes < kSmallPart * limit) return;
  optim::ForecastStages(
      experiment.scene, experiment.observations, experiment.fit, optim::ForecastParts::kMemory);
}

ExitStatus Fit(CommandContext& context, const Options& own) {
  const ExperimentConfig config = LoadExperimentConfig(context.line.target, context.line.overrides);
  RequireFittable(config, own.stop_after);
  const int threads = NumThreads(context.line, config.threads);
  const renderer::ThreadLimit limit(threads);
  Experiment experiment = BuildExperiment(config, context.ranks);
  if (!context.ranks.IsFirst()) return Follow(context, experiment);
  const StartCheck start = CheckStart(config, experiment);
  RequireMemoryOf(config, experiment);

  RunRecord record = MakeRunRecord(context.line.arguments);
  record.name = config.name;
  FillProgramInfo(record);
  record.threads = threads;
  record.seed = config.render.seed;
  record.config_path = config.path.string();
  const std::string resolved = ResolvedYaml(config, experiment.scene);
  record.resolved_sha256 = Sha256Hex(resolved);
  record.inputs = HashInputs(experiment.input_files);
  record.assumptions = experiment.assumptions;
  record.attributions = experiment.attributions;

  const RunDirectory run =
      CreateRunDirectory(config.output.directory, config.name, std::chrono::system_clock::now());
  const std::unique_ptr<FileLock> lock = LockRun(run);
  renderer::WriteFileAtomically(run.Config(), config.given_text);
  renderer::WriteFileAtomically(run.ResolvedConfig(), resolved);
  context.log.AddFile(run.LogFile());
  for (const std::string& text : experiment.assumptions) context.log.Info(text);
  for (const std::string& text : experiment.warnings) context.log.Warn(text);
  for (const std::string& text : start.warnings) context.log.Warn(text);
  context.log.Info("run directory " + run.root().string());
  RunRecordFile record_file(run.Record(), record);
  const ExitStatus status =
      RunInDirectory(context, own, config, experiment, run, record_file, std::nullopt);
  PrintRun(context, run);
  return status;
}

[[noreturn]] void RefuseChanged(const std::string& path) {
  throw renderer::IoError(path + ": has changed since the run began; start a new fit");
}

ExitStatus Resume(CommandContext& context, const Options& own) {
  const RunDirectory run = OpenRunDirectory(context.line.target);
  const std::unique_ptr<FileLock> lock = context.ranks.IsFirst() ? LockRun(run) : nullptr;
  const RunRecord before = context.ranks.IsFirst() ? ReadRunRecord(run.Record()) : RunRecord{};
  if (!before.resolved_sha256.empty() && fs::exists(run.ResolvedConfig()) &&
      Sha256OfFile(run.ResolvedConfig()) != before.resolved_sha256) {
    RefuseChanged(run.ResolvedConfig().string());
  }
  const ExperimentConfig config =
      LoadExperimentConfig(run.ResolvedConfig(), context.line.overrides);
  const renderer::ThreadLimit limit(NumThreads(context.line, config.threads));
  Experiment experiment = BuildExperiment(config, context.ranks);
  if (!context.ranks.IsFirst()) return Follow(context, experiment);
  for (const std::string& text : experiment.warnings) context.log.Warn(text);
  RequireMemoryOf(config, experiment);

  std::vector<std::string> changed = ChangedInputs(before);
  // In records of older versions, a config that was edited may name others.
  for (std::size_t i = 0; i < std::min(experiment.input_files.size(), before.inputs.size()); ++i) {
    const std::string path = experiment.input_files[i].string();
    if (path != before.inputs[i].path) changed.push_back(path);
  }
  if (!changed.empty()) RefuseChanged(changed.front());
  context.log.AddFile(run.LogFile());
  auto [state, damaged] =
      optim::ReadNewestCheckpoint(run.Checkpoints(), {experiment.scene, experiment.fit.unknowns});
  for (const std::string& reason : damaged) {
    context.log.Warn("a checkpoint is left out, and an older one continued: " + reason);
  }
  context.log.Info(state
                       ? fmt::format("resuming {} after round {}", run.root().string(), state->step)
                       : "no checkpoint yet: starting over in " + run.root().string());
  RunRecordFile record_file(run.Record(), context.line.arguments, state ? state->step : 0);
  const ExitStatus status =
      RunInDirectory(context, own, config, experiment, run, record_file, std::move(state));
  PrintRun(context, run);
  return status;
}

}  // namespace

extern const Command kFitCommand = {"fit",
                                    "Fits a scene to photos; prints the run directory",
                                    "CONFIG",
                                    Prepare<Options, DeclareFit, Fit>,
                                    kResult,
                                    true};
extern const Command kResumeCommand = {"resume",
                                       "Continues a run from its newest checkpoint",
                                       "RUN",
                                       Prepare<Options, DeclareResume, Resume>,
                                       kResult,
                                       true};

}  // namespace pathfit::app::fit_command
