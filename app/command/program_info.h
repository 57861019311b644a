#pragma once

#include <exception>

#include "app/command/command_line.h"
#include "app/command/exit_status.h"
#include "app/config/experiment_config.h"
#include "app/output/run_record.h"

namespace pathfit::app {

/// Version, build and library versions.
void FillProgramInfo(RunRecord& record);

/// --threads, then the config, then the environment, then what the machine gives.
int NumThreads(const CommandLine& line, const ExperimentConfig& config);

/// The status a command ends with when this exception reaches main.
ExitStatus StatusOfException(const std::exception& error);

}  // namespace pathfit::app
