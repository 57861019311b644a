#pragma once

#include <string>

#include "app/command/command_line.h"

namespace pathfit::app {

// Scripts that complete the command line in a shell: commands, options, words that an option or
// argument may be, keys of --set, files and folders.

std::string BashCompletion(const DeclaredProgram& program);
std::string ZshCompletion(const DeclaredProgram& program);
std::string FishCompletion(const DeclaredProgram& program);

/// "seed", "solver.threads" ...: what --set can name in any config.
std::vector<std::string> SettableKeys();

}  // namespace pathfit::app
