#pragma once

#include <string>

#include "app/command/command_line.h"

namespace pathfit::app {

/// pathfit.1, for man.
std::string ManPage(const DeclaredProgram& program, const std::string& version);

/// app/command/README.md: every command with its options and what --json prints.
std::string CommandMarkdown(const DeclaredProgram& program);

}  // namespace pathfit::app
