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

#ifdef __clang__
constexpr const char* kCompiler = __VERSION__;  // with its name
#else
constexpr const char* kCompiler = "GCC " __VERSION__;
#endif

template <class... Kinds>
bool IsOneOf(const std::exception& error) {
  return ((dynamic_cast<const Kinds*>(&error) != nullptr) || ...);
}

}  // namespace

// Each is `kNAMECommand` in the namespace of its own file, FILE_command; in the order of the help.
#define PATHFIT_COMMANDS(ROW) \
  ROW(init, Init)             \
  ROW(check, Check)           \
  ROW(fit, Fit)               \
  ROW(fit, Resume)            \
  ROW(render, Render)         \
  ROW(list, List)             \
  ROW(export, Export)         \
  ROW(report, Report)         \
  ROW(serve, Serve)           \
  ROW(compare, Compare)       \
  ROW(eval, Eval)             \
  ROW(sweep, Sweep)           \
  ROW(synth, Synth)           \
  ROW(convert, Convert)       \
  ROW(gradcheck, Gradcheck)   \
  ROW(config, Config)         \
  ROW(completion, Completion) \
  ROW(info, Info)             \
  ROW(info, Version)

#define PATHFIT_DECLARE(file, name)        \
  namespace file##_command {               \
    extern const Command k##name##Command; \
  }
PATHFIT_COMMANDS(PATHFIT_DECLARE)

const Commands& AllCommands() {
#define PATHFIT_ADDRESS(file, name) &file##_command::k##name##Command,
  static const Commands commands = {PATHFIT_COMMANDS(PATHFIT_ADDRESS)};
  return commands;
}

void FillProgramInfo(RunRecord& record) {
  record.program_version = PATHFIT_VERSION;
  record.build = std::string(kCompiler) + " " + PATHFIT_BUILD_TYPE;
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
