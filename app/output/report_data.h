#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/output/fit_history.h"
#include "app/output/run_directory.h"
#include "app/output/run_record.h"
#include "optim/round/fit_report.h"

namespace pathfit::app {

/// One view's pictures (JPEG bytes, empty when there are none) and numbers.
struct ReportView {
  optim::ViewReport start, last;
  bool has_start = false;
  std::string photo, start_fit, result_fit, difference, silhouette;

  [[nodiscard]] std::size_t ImageBytes() const {
    return photo.size() + start_fit.size() + result_fit.size() + difference.size() +
           silhouette.size();
  }
};

/// Everything a report shows, as it is on disk.
struct ReportData {
  std::string run_path;
  std::string status;  ///< StatusName or "killed"
  RunRecord record;
  FitHistory history;
  std::string config, resolved_config;
  std::vector<ReportView> views;                       ///< in the order of the last stage's report
  std::string environment_initial, environment_final;  ///< PNG bytes
};

/// Reads a run directory; what a run that ended early has not written is left empty.
/// Throws IoError when run.json is missing, or a file is malformed.
ReportData LoadReportData(const RunDirectory& run);

/// Entry of the start of the run and of the newest stage; null when there is none.
const optim::StageReport* StartReport(const FitHistory& history);
const optim::StageReport* LastReport(const FitHistory& history);
bool HasValidation(const optim::StageReport& report);

/// Where a view's small pictures are kept: `kind` is photo, start, result, difference or
/// silhouette.
std::filesystem::path ThumbnailPath(const RunDirectory& run,
                                    const std::string& view_folder,
                                    const std::string& kind);

}  // namespace pathfit::app
