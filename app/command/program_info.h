#pragma once

#include <exception>
#include <string>

#include "app/command/command_line.h"
#include "app/command/exit_status.h"
#include "app/output/run_record.h"

namespace pathfit::app {

/// Version, build and library versions.
void FillProgramInfo(RunRecord& record);

/// --threads, then the config, then the environment, then what the machine gives.
/// `in_config` is 0 for auto.
int NumThreads(const CommandLine& line, int in_config);

/// Prints on standard error what -q must not hide, if the log does not show it.
void ShowThoughQuiet(CommandContext& context, const std::string& text);

/// The status a command ends with when this exception reaches main.
ExitStatus StatusOfException(const std::exception& error);

}  // namespace pathfit::app
