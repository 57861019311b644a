#include <filesystem>
#include <new>

#include "app/command/command_line.h"
#include "app/config/config_error.h"
#include "app/config/thread_count.h"
#include "optim/problem/problem_size.h"
#include "optim/solver/trust_region_solver.h"
#include "renderer/core/error.h"
#include "renderer/geometry/ray_caster.h"
#include "renderer/io/disk_full_error.h"
#include "renderer/io/raw_file.h"

namespace pathfit::app {
namespace {

template <class... Kinds>
bool IsOneOf(const std::exception& error) {
  return ((dynamic_cast<const Kinds*>(&error) != nullptr) || ...);
}

}  // namespace

// Each is `kNAMECommand` of its own file; in the order of the help.
#define PATHFIT_COMMANDS(ROW) \
  ROW(Init)                   \
  ROW(Check)                  \
  ROW(Fit)                    \
  ROW(Resume)                 \
  ROW(Render)                 \
  ROW(List)                   \
  ROW(Export)                 \
  ROW(Report)                 \
  ROW(Serve)                  \
  ROW(Compare)                \
  ROW(Eval)                   \
  ROW(Sweep)                  \
  ROW(Synth)                  \
  ROW(Convert)                \
  ROW(Gradcheck)              \
  ROW(Config)                 \
  ROW(Completion)             \
  ROW(Info)                   \
  ROW(Version)

#define PATHFIT_DECLARE(name) extern const Command k##name##Command;
PATHFIT_COMMANDS(PATHFIT_DECLARE)

const Commands& AllCommands() {
#define PATHFIT_ADDRESS(name) &k##name##Command,
  static const Commands commands = {PATHFIT_COMMANDS(PATHFIT_ADDRESS)};
  return commands;
}

void FillProgramInfo(RunRecord& record) {
  record.program_version = PATHFIT_VERSION;
  record.build = std::string("GCC ") + __VERSION__ + " " + PATHFIT_BUILD_TYPE;
  record.libraries = {{"Embree", renderer::EmbreeVersion()}, {"Ceres", optim::CeresVersion()}};
  const std::string raw = renderer::LibRawVersion();
  record.libraries["LibRaw"] = raw.empty() ? "none (RAW photos are not read)" : raw;
}

int NumThreads(const CommandLine& line, int in_config) {
  return NumThreads(line.threads, in_config, line.default_threads);
}

ExitStatus StatusOfException(const std::exception& error) {
  if (IsOneOf<UsageError>(error)) return ExitStatus::kUsage;
  if (IsOneOf<ConfigError>(error)) return ExitStatus::kConfig;
  if (IsOneOf<renderer::DiskFullError>(error)) return ExitStatus::kStopped;
  if (IsOneOf<renderer::IoError, renderer::SceneError, std::filesystem::filesystem_error>(error))
    return ExitStatus::kInput;
  if (IsOneOf<renderer::NumericalError>(error)) return ExitStatus::kNumerical;
  if (IsOneOf<optim::MemoryError, std::bad_alloc>(error)) return ExitStatus::kMemory;
  if (IsOneOf<renderer::Cancelled>(error)) return ExitStatus::kStopped;
  return ExitStatus::kInternalError;
}

}  // namespace pathfit::app
