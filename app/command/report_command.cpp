#include <cstdio>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/output/report.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app::report_command {
namespace {

namespace fs = std::filesystem;

constexpr double kBytesPerMegabyte = 1e6;

struct Options {
  fs::path output;
  double max_size_mb = 8.0;
};

void Declare(OptionList& options, Options& own) {
  options.Path("-o,--output", "FILE", "Page to write; else report.html in the run", own.output);
  options.Number(
      "--max-size-mb", "Views are left out to stay below it", 0.1, 1000.0, own.max_size_mb);
}

constexpr ResultKey kResult[] = {
    {"run", "text", "The run directory"},
    {"status", "text", "running, finished, stopped, failed, or killed"},
    {"reason", "text", "Why it ended"},
    {"stages", "whole", "Number of stages that ended, the start counted"},
    {"rounds", "whole", "Number of rounds that were done"},
    {"page", "text", "The page that was written"}};

ExitStatus Run(CommandContext& context, const Options& own) {
  const CommandLine& line = context.line;
  const RunDirectory run = OpenRunDirectory(line.target);
  const ReportData data = LoadReportData(run);
  ReportOptions options;
  options.max_bytes = static_cast<std::size_t>(own.max_size_mb * kBytesPerMegabyte);
  const fs::path page =
      fs::absolute(own.output.empty() ? run.Report() : own.output).lexically_normal();
  const std::string text = ReportPage(ReportJson(data, options));
  renderer::WriteFileAtomically(page, text);
  if (text.size() > options.max_bytes) {
    context.log.Warn(fmt::format(
        "the page has {:.1f} MB, more than --max-size-mb {:g}: what is left after views "
        "are left out",
        static_cast<double>(text.size()) / kBytesPerMegabyte,
        own.max_size_mb));
  }
  if (data.status != "finished") {
    context.log.Warn(fmt::format("the run is {}; the page shows the {} rounds that are recorded",
                                 data.status,
                                 data.history.rounds.size()));
  }
  if (line.json) {
    PrintResult(context,
                {{"run", run.root().string()},
                 {"status", data.status},
                 {"reason", data.record.reason},
                 {"stages", data.history.stages.size()},
                 {"rounds", data.history.rounds.size()},
                 {"page", page.string()}});
  } else {
    fmt::print("{}\n", page.string());
  }
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kReportCommand = {
    "report",
    "Writes the report of a run anew, also of one that runs, was stopped or killed",
    "RUN",
    Prepare<Options, Declare, Run>,
    kResult};

}  // namespace pathfit::app::report_command
