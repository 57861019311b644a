#include "app/command/program_info.h"

#include <new>

#include "app/config/config_error.h"
#include "optim/problem/problem_size.h"
#include "optim/solver/trust_region_solver.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/geometry/ray_caster.h"

namespace pathfit::app {

void FillProgramInfo(RunRecord& record) {
  record.program_version = PATHFIT_VERSION;
  record.build = std::string("GCC ") + __VERSION__ + " " + PATHFIT_BUILD_TYPE;
  record.libraries = {{"Embree", renderer::EmbreeVersion()}, {"Ceres", optim::CeresVersion()}};
}

int NumThreads(const CommandLine& line, int in_config) {
  if (line.threads) return *line.threads;
  if (in_config > 0) return in_config;
  return line.default_threads ? *line.default_threads : renderer::DefaultNumThreads();
}

void ShowThoughQuiet(CommandContext& context, const std::string& text) {
  if (context.line.log_level > LogLevel::kWarn) context.terminal.PrintLine("warning: " + text);
}

ExitStatus StatusOfException(const std::exception& error) {
  const auto is = [&]<class T>(const T*) { return dynamic_cast<const T*>(&error) != nullptr; };
  if (is(static_cast<UsageError*>(nullptr))) return ExitStatus::kUsage;
  if (is(static_cast<ConfigError*>(nullptr))) return ExitStatus::kConfig;
  if (is(static_cast<renderer::IoError*>(nullptr)) ||
      is(static_cast<renderer::SceneError*>(nullptr))) {
    return ExitStatus::kInput;
  }
  if (is(static_cast<renderer::NumericalError*>(nullptr))) return ExitStatus::kNumerical;
  if (is(static_cast<optim::MemoryError*>(nullptr)) || is(static_cast<std::bad_alloc*>(nullptr))) {
    return ExitStatus::kMemory;
  }
  if (is(static_cast<renderer::Cancelled*>(nullptr))) return ExitStatus::kStopped;
  return ExitStatus::kInternalError;
}

}  // namespace pathfit::app
