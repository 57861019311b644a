#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/config/config_error.h"
#include "app/output/log.h"
#include "app/output/terminal.h"

namespace pathfit::app {

enum class CommandName { kCheck, kFit, kResume, kRender, kGradcheck, kVersion, kHelp };

/// What the user asked for: values only, checked one by one; nothing has been opened.
struct CommandLine {
  CommandName command = CommandName::kHelp;
  std::string help_text;               ///< kHelp: goes to stdout
  std::filesystem::path target;        ///< CONFIG or RUN, relative to the working directory
  std::vector<std::string> arguments;  ///< argv as given, for the record of the run

  // Every command.
  LogLevel log_level =
      LogLevel::kInfo;  ///< -v debug, -vv trace, -q error, --log-level, PATHFIT_LOG_LEVEL
  std::filesystem::path log_file;  ///< empty: none beside that of the run
  std::optional<int> threads;      ///< --threads
  std::optional<int>
      default_threads;  ///< PATHFIT_THREADS or SLURM_CPUS_PER_TASK, where the config says auto
  std::optional<std::int64_t> seed;
  ColorMode color = ColorMode::kAuto;
  ProgressMode progress = ProgressMode::kAuto;
  bool json = false;  ///< machine-readable result on stdout

  // Some commands.
  std::vector<std::string> set;           ///< "key.path=VALUE", in order
  std::filesystem::path output;           ///< -o; empty: as the config says
  double time_limit_s = 0.0;              ///< 0 = none
  std::optional<std::string> max_memory;  ///< "12GiB", checked
  std::string stop_after;                 ///< name of a stage, empty: none
  std::vector<std::string> views;  ///< render: indices or names of photos or sensors; empty: all
  std::vector<std::string> derivatives;  ///< render: parameters
  std::string terms;                     ///< render: comma-separated; empty: as the config says
  std::string form;                      ///< render, gradcheck: image or material; empty: config
  std::vector<std::string> params;       ///< gradcheck: names or globs; empty: as the config says
  std::optional<double> step;
  std::optional<int> spp;         ///< render, gradcheck
  std::optional<int> replicates;  ///< gradcheck
  std::optional<double> sigma;
};

/// The command line is wrong: what() is the complete message, the status is ExitStatus::kUsage.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Parses argv (the program's name first). Flags may stand anywhere. Throws UsageError with the
/// nearest command or option when a word is unknown, also for wrong values of PATHFIT_THREADS and
/// PATHFIT_LOG_LEVEL.
CommandLine ParseCommandLine(const std::vector<std::string>& arguments,
                             const Environment& environment);

/// The changes to the config that the command line makes, in order of precedence: every --set, then
/// the dedicated flags (--seed, --threads, --max-memory; of fit -o; of gradcheck --params, --step,
/// --spp, --replicates, --sigma; of render --spp).
std::vector<ConfigOverride> OverridesOf(const CommandLine& line);

}  // namespace pathfit::app
