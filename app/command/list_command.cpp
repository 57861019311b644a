#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "app/command/command_line.h"
#include "app/command/result.h"
#include "app/output/comparison.h"
#include "app/output/progress.h"
#include "app/output/run_directory.h"
#include "app/output/run_record.h"
#include "app/output/terminal.h"
#include "renderer/core/error.h"

namespace pathfit::app::list_command {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 4;  // folders below the one that is listed

struct Options {};

void Declare(OptionList& /*options*/, Options& /*own*/) {}

constexpr ResultKey kResult[] = {
    {"folder", "text", "That was looked through"},
    {"runs",
     "list",
     "The oldest first: maps of run, name, status, started_utc, stages (that ended), rounds (of "
     "these), psnr_srgb_val_db (held out, after the last of them) and wall_s; of a record that "
     "cannot be read, status is unreadable and the rest null"}};

/// Adds the folders with a record, without following links (`latest` would be listed twice).
void FindRuns(const fs::path& folder, int depth, std::vector<fs::path>& runs) {
  std::error_code error;
  if (fs::is_regular_file(RunDirectory(folder).Record(), error)) {
    runs.push_back(folder);
    return;
  }
  if (depth == kDeepest) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_directory(error) && !entry.is_symlink(error)) {
      FindRuns(entry.path(), depth + 1, runs);
    }
  }
}

Json Describe(const fs::path& run, Log& log) {
  Json json = {{"run", run.string()},
               {"name", nullptr},
               {"status", "unreadable"},
               {"started_utc", nullptr},
               {"stages", nullptr},
               {"rounds", nullptr},
               {"psnr_srgb_val_db", nullptr},
               {"wall_s", nullptr}};
  try {
    const RunRecord record = ReadRunRecord(RunDirectory(run).Record());
    int stages = 0, rounds = 0;
    double psnr = std::numeric_limits<double>::quiet_NaN();
    for (const optim::StageReport& stage : record.stages) {
      stages += stage.stage == "start" ? 0 : 1;
      rounds += stage.rounds;
      psnr = stage.psnr_srgb_val;
    }
    json["name"] = record.name;
    json["status"] = EffectiveStatus(record, run);
    json["started_utc"] = record.started_utc;
    json["stages"] = stages;
    json["rounds"] = rounds;
    json["psnr_srgb_val_db"] = ToJson(psnr);
    json["wall_s"] = record.wall_s;
  } catch (const renderer::IoError& error) {
    log.Warn(error.what());
  }
  return json;
}

/// "-" where it is not known.
std::string Cell(const Json& value) {
  if (value.is_null()) return "-";
  return value.is_string() ? WithoutControls(value.get<std::string>()) : JsonText(value, -1);
}

std::string Table(const fs::path& folder, const Json& runs) {
  std::vector<std::vector<std::string>> rows = {
      {"Run", "Name", "Status", "Started", "Stages", "Rounds", "PSNR sRGB held out", "Time"}};
  for (const Json& run : runs) {
    const Json& psnr = run["psnr_srgb_val_db"];
    const Json& wall = run["wall_s"];
    rows.push_back({Cell(fs::path(run["run"].get<std::string>()).lexically_relative(folder)),
                    Cell(run["name"]),
                    Cell(run["status"]),
                    Cell(run["started_utc"]),
                    Cell(run["stages"]),
                    Cell(run["rounds"]),
                    psnr.is_number() ? fmt::format("{:.2f} dB", psnr.get<double>()) : "-",
                    wall.is_null() ? "-" : DurationText(wall.get<double>())});
  }
  return AlignedTable(rows);
}

ExitStatus Run(CommandContext& context, const Options& /*own*/) {
  const CommandLine& line = context.line;
  const fs::path folder = fs::absolute(line.targets.empty() ? "runs" : line.targets.front());
  if (!fs::is_directory(folder)) {
    throw renderer::IoError(folder.string() + ": is no folder; give the one that runs are in");
  }
  std::vector<fs::path> found;
  FindRuns(folder, 0, found);
  std::vector<Json> rows;
  for (const fs::path& run : found) rows.push_back(Describe(run, context.log));
  // Names of folders are numbered from -2 on where runs start in the same second.
  std::ranges::sort(rows, {}, [](const Json& row) {
    return std::pair(Cell(row["started_utc"]), row["run"].get<std::string>());
  });
  Json runs = rows;
  if (line.json) {
    PrintResult(context, {{"folder", folder.string()}, {"runs", std::move(runs)}});
  } else if (rows.empty()) {
    context.log.Info(folder.string() + ": holds no runs");
  } else {
    fmt::print("{}", Table(folder, runs));
  }
  return ExitStatus::kFinished;
}

}  // namespace

extern const Command kListCommand = {"list",
                                     "Lists the runs in a folder; else those in runs",
                                     "[FOLDER]",
                                     Prepare<Options, Declare, Run>,
                                     kResult};

}  // namespace pathfit::app::list_command
