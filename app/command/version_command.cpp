#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/program_info.h"
#include "app/output/fields.h"

namespace pathfit::app {
namespace {

void Declare(OptionList& /*options*/, CommandLine& /*line*/) {}

ExitStatus Run(CommandContext& context) {
  RunRecord record;
  FillProgramInfo(record);
  if (context.line.json) {
    Json json = {{"version", record.program_version}, {"build", record.build}};
    for (const auto& [name, version] : record.libraries) json["libraries"][name] = version;
    fmt::print("{}\n", JsonText(json));
    return ExitStatus::kFinished;
  }
  fmt::print("pathfit {} ({})\n", record.program_version, record.build);
  for (const auto& [name, version] : record.libraries) fmt::print("  {} {}\n", name, version);
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kVersionCommand = {"version", "Prints the version", nullptr, Declare, Run};

}  // namespace pathfit::app
