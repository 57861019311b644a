#include "app/command/command_line.h"

namespace pathfit::app {

extern const Command kCheckCommand, kFitCommand, kResumeCommand, kRenderCommand, kGradcheckCommand,
    kInfoCommand, kVersionCommand;

const std::vector<const Command*>& AllCommands() {
  static const std::vector<const Command*> commands = {&kCheckCommand,
                                                       &kFitCommand,
                                                       &kResumeCommand,
                                                       &kRenderCommand,
                                                       &kGradcheckCommand,
                                                       &kInfoCommand,
                                                       &kVersionCommand};
  return commands;
}

}  // namespace pathfit::app
