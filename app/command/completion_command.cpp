#include <cstdio>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/command_reference.h"
#include "app/command/shell_completion.h"

namespace pathfit::app::completion_command {
namespace {

ExitStatus Run(CommandContext& context) {
  const std::string what = context.line.target.string();
  const DeclaredProgram program = DescribeProgram();
  if (context.line.json) throw UsageError("completion", "--json has no use, it is a script");
  fmt::print("{}",
             what == "bash"   ? BashCompletion(program)
             : what == "zsh"  ? ZshCompletion(program)
             : what == "fish" ? FishCompletion(program)
                              : ManPage(program, PATHFIT_VERSION));
  return ExitStatus::kFinished;
}

Action PrepareCompletion(OptionList& /*options*/) { return Run; }

}  // namespace

extern const Command kCompletionCommand = {
    "completion",
    "Prints a script that completes commands and options in a shell, or the man page",
    "bash|zsh|fish|man",
    PrepareCompletion};

}  // namespace pathfit::app::completion_command
