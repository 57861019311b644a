#pragma once

#include <string>
#include <vector>

#include "app/output/report.h"

namespace pathfit::app {

/// One run among others: what its files say, and how it is called beside them.
struct ComparedRun {
  std::string label;  ///< shortest of name, folder and path that tells the runs apart
  ReportData data;
};

/// Loads the runs in the order given. Throws IoError as LoadReportData.
std::vector<ComparedRun> LoadRuns(const std::vector<RunDirectory>& runs);

/// Settings by their full key that are not the same in all runs: of each run its value, "-" where
/// it has none. Names, places of output and input paths count like any other.
struct Difference {
  std::string key;
  std::vector<std::string> values;
};
std::vector<Difference> DifferencesOf(const std::vector<ComparedRun>& runs);

/// A figure of a run in tables: its key in JSON, heading, value, and that as text.
struct FigureColumn {
  const char* key;
  const char* heading;
  double (*value)(const ComparedRun& run);  ///< NaN where it is not known
  std::string (*text)(double value);
};
const std::vector<FigureColumn>& FigureColumns();

/// Columns as wide as they need to be; the first is left-aligned.
std::string AlignedTable(const std::vector<std::vector<std::string>>& rows);

/// Result of each run as figures (`runs`, with `label` and `run_path`), and `differences`: what
/// `pathfit compare --json` prints.
Json ComparisonFigures(const std::vector<ComparedRun>& runs);
/// The same for people: a line for each run, "-" for what is not known, then the differences.
std::string ComparisonTable(const std::vector<ComparedRun>& runs);

/// What ReportPage draws as a comparison: ComparisonFigures with the rounds of each run
/// (`history`), and `views`: name, whether held out, the photo and of each run its picture, with
/// its photo where that is another one of this name, as far as `options.max_bytes` allow; held-out
/// views first, the worst first.
Json ComparisonJson(const std::vector<ComparedRun>& runs, const ReportOptions& options);

}  // namespace pathfit::app
