#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "app/output/fit_history.h"
#include "app/output/run_directory.h"
#include "app/output/run_record.h"

namespace pathfit::app {

/// Kinds of a view's small pictures.
inline constexpr const char* kViewPictures[] = {
    "photo", "start", "result", "difference", "silhouette"};

/// Everything a report shows, as it is on disk.
struct ReportData {
  std::string run_path;
  std::string status;  ///< name of a RunStatus, or "killed"
  RunRecord record;
  FitHistory history;
  std::string config, resolved_config;
  /// One entry for each view of the last stage, in its order: JPEG bytes by kind; kinds that there
  /// are no pictures of are missing.
  std::vector<std::map<std::string, std::string>> view_pictures;
  std::string environment_initial, environment_final;  ///< PNG bytes
  Json start_model, model;  ///< of the 3-D view (viewed_model.h), null where there are none
};

struct ReportOptions {
  std::size_t max_bytes = 8'000'000;  ///< of the whole file; views are left out to stay below it
};

/// Reads a run directory; what a run that ended early has not written is left empty.
/// Throws IoError when run.json is missing, or a file is malformed.
ReportData LoadReportData(const RunDirectory& run);

/// What the page draws: run.json as `run`, history.json as `history`, the list of figures, and what
/// is decided here: the verdict in words (`sentence`, `warnings`), which views are shown and why
/// (`views`, `views_note`), pictures as data URIs. `model`: `start` and `result` of the 3-D view,
/// each null where it would take more than half of `max_bytes`, and a `note` that says so; null
/// where the run has none.
Json ReportJson(const ReportData& data, const ReportOptions& options);

/// One HTML file that draws this with its own script, offline and without loading anything; nothing
/// of the data can become markup or script.
std::string ReportPage(const Json& json);

/// The page that `pathfit serve` shows: it asks for `data.json` beside it, the newest ReportJson,
/// and loads nothing else.
std::string LivePage(const Json& json);

/// Loads the run directory and writes its report.html. Throws IoError as LoadReportData, or when
/// not writable.
void WriteReport(const RunDirectory& run, const ReportOptions& options = {});

/// Problems of the result that a person should look at, beside the run's own warnings.
std::vector<std::string> DerivedWarnings(const FitHistory& history);

/// Where a view's small pictures are kept, see kViewPictures.
std::filesystem::path ThumbnailPath(const RunDirectory& run,
                                    const std::string& view_folder,
                                    const std::string& kind);

/// Files of app/output/report/, put into the program when it is built.
std::string_view ReportHtml();
std::string_view ReportCss();
std::string_view ReportJs();
/// What follows a run, which only LivePage contains.
std::string_view LiveJs();
/// The 3-D library with its licence, which only pages with a model contain.
std::string_view ThreeJs();

}  // namespace pathfit::app
