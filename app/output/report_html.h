#pragma once

#include <cstddef>
#include <string>

#include "app/output/report_data.h"

namespace pathfit::app {

struct ReportOptions {
  std::size_t max_bytes = 8'000'000;  ///< of the whole file; views are left out to stay below it
  int max_fitted_views = 8;           ///< the worst ones; held-out views are all shown
};

/// One HTML file that works offline, without network and without scripts; everything from the run
/// is escaped.
std::string BuildReportHtml(const ReportData& data, const ReportOptions& options);

/// Loads the run directory and writes its report.html. Throws IoError as LoadReportData, or when
/// not writable.
void WriteReport(const RunDirectory& run, const ReportOptions& options = {});

}  // namespace pathfit::app
