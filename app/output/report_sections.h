#pragma once

#include <string>
#include <vector>

#include "app/output/report_data.h"

namespace pathfit::app {

/// Parts of a report, each a complete HTML fragment; empty when there is nothing to show.
std::string VerdictSection(const ReportData& data);
std::string StageTableSection(const ReportData& data);
std::string CurvesSection(const FitHistory& history);
std::string ParametersSection(const FitHistory& history);
std::string ExposureSection(const FitHistory& history);
std::string EnvironmentSection(const ReportData& data);
std::string TimingSection(const FitHistory& history);
std::string AssumptionsSection(const RunRecord& record);
std::string ReproductionSection(const ReportData& data);

/// Heading and legend before the views; `note` says which are shown.
std::string ViewsIntroduction(const std::string& note);
std::string ViewArticle(const ReportView& view, const std::string& result_name);

/// Problems of the result that a person should look at, beside the run's own warnings.
std::vector<std::string> DerivedWarnings(const FitHistory& history);

/// "17.9 → 27.3 dB"; only the last value when there is no start.
std::string ChangeText(
    bool has_start, double start, double last, int digits, const std::string& unit);
std::string DataUri(const std::string& mime, const std::string& bytes);

}  // namespace pathfit::app
