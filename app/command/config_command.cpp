#include <cstdio>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/config/experiment_config.h"
#include "app/config/resolved_yaml.h"
#include "app/config/schema.h"
#include "app/output/config_json.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app::config_command {
namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path output;
};

void Declare(OptionList& options, Options& own) {
  options.Set();
  options.Seed();
  options.Threads();
  options.MaxMemory();
  options.Path("-o,--output", "FILE", "File to write; else it is printed", own.output);
  options.Check([&options] {
    const CommandLine& line = options.line();
    const bool show = line.target == "show";
    if (show && line.targets.size() < 2) options.Fail("show: CONFIG is missing");
    if (!show && line.targets.size() > 1) {
      options.Fail(line.target.string() + " takes no CONFIG; only show does");
    }
    if (show) return;
    for (const ConfigOverride& given : line.overrides) {
      options.Fail(given.label.substr(0, given.label.find(' ')) + " needs show");
    }
  });
}

constexpr ResultKey kResult[] = {
    {"config", "text or null", "show: the file"},
    {"values", "map", "show: every value of the config. schema: the JSON Schema"},
    {"origins",
     "map or null",
     "show: where each value was written, by its path: default, FILE:LINE:COLUMN, --set #N"}};

ExitStatus Run(CommandContext& context, const Options& own) {
  const CommandLine& line = context.line;
  std::string text;
  Json result = {{"config", nullptr}, {"values", nullptr}, {"origins", nullptr}};
  if (line.target == "show") {
    const ExperimentConfig config = LoadExperimentConfig(line.targets[1], line.overrides);
    text = WriteResolvedYaml(config.resolved, config.source);
    result["config"] = config.path.string();
    result["values"] = PlainJson(config.resolved);
    result["origins"] = OriginsJson(config.resolved, config.source);
  } else if (line.target == "schema") {
    result["values"] = ConfigJsonSchema(ConfigSchema());
    text = JsonText(result["values"]) + "\n";
  } else {
    text = SchemaYaml();
    if (line.json) throw UsageError("config", "default is YAML with comments: --json has no use");
  }
  if (!own.output.empty()) {
    renderer::WriteFileAtomically(fs::absolute(own.output), text);
    context.log.Info("written: " + fs::absolute(own.output).lexically_normal().string());
    if (line.json) PrintResult(context, result);
  } else if (line.json) {
    PrintResult(context, result);
  } else {
    fmt::print("{}", text);
  }
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kConfigCommand = {
    "config",
    "Shows a config with all defaults and where each value came from; all settings; their schema",
    "show|default|schema [CONFIG]",
    Prepare<Options, Declare, Run>,
    kResult};

}  // namespace pathfit::app::config_command
