#include <cstdio>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/output/comparison.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app::compare_command {
namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path output;
};

void Declare(OptionList& options, Options& own) {
  options.Path("-o,--output", "FILE", "Page to write; else compare.html here", own.output);
  options.Check([&options] {
    if (options.line().targets.size() < 2) options.Fail("at least two runs are needed");
  });
}

constexpr ResultKey kResult[] = {
    {"columns", "list", "Maps of key and heading: the figures of a run"},
    {"runs", "list", "Maps with label, run_path, status, stage and the figures"},
    {"differences", "list", "Settings that differ: maps of key and values, one for each run"},
    {"page", "text", "The page that was written"}};

ExitStatus Run(CommandContext& context, const Options& own) {
  const CommandLine& line = context.line;
  std::vector<RunDirectory> directories;
  for (const fs::path& target : line.targets) directories.push_back(OpenRunDirectory(target));
  const std::vector<ComparedRun> runs = LoadRuns(directories);
  const fs::path page = fs::absolute(own.output.empty() ? "compare.html" : own.output);
  renderer::WriteFileAtomically(page, ReportPage(ComparisonJson(runs, {})));
  if (line.json) {
    Json json = ComparisonFigures(runs);
    json["page"] = page.string();
    PrintResult(context, std::move(json));
  } else {
    fmt::print("{}", ComparisonTable(runs));
  }
  context.log.Info("curves and pictures: " + page.string());
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kCompareCommand = {
    "compare",
    "Compares runs: a table, and a page with curves and pictures",
    "RUN...",
    Prepare<Options, Declare, Run>,
    kResult};

}  // namespace pathfit::app::compare_command
