#pragma once

#include "app/command/command_line.h"
#include "app/output/fields.h"

namespace pathfit::app {

/// Prints what --json asks for: one object that begins with `schema`, "pathfit-COMMAND-1". Its keys
/// must be those that the command declares, with values of their types; throws std::logic_error
/// otherwise.
void PrintResult(const CommandContext& context, const Json& result);

/// Throws std::logic_error unless the object has the declared keys and types, and no others.
void RequireDeclared(const Command& command, const Json& result);

}  // namespace pathfit::app
