#pragma once

#include "app/command/command_line.h"
#include "app/command/exit_status.h"
#include "app/output/log.h"
#include "app/output/terminal.h"

namespace pathfit::app {

/// What every command uses to speak: standard error through terminal and log; results alone go to
/// standard output.
struct CommandContext {
  const CommandLine& line;
  Terminal& terminal;
  Log& log;
};

/// The commands. Wrong input throws: ConfigError, IoError, SceneError, MemoryError, NumericalError.
ExitStatus CheckCommand(CommandContext& context);
ExitStatus FitCommand(CommandContext& context);
ExitStatus ResumeCommand(CommandContext& context);
ExitStatus RenderCommand(CommandContext& context);
ExitStatus GradcheckCommand(CommandContext& context);
ExitStatus VersionCommand(CommandContext& context);

}  // namespace pathfit::app
