#pragma once

#include <string_view>

namespace pathfit::app {

/// Files of app/output/report/, put into the program when it is built.
extern const std::string_view kReportHtml;
extern const std::string_view kReportCss;
extern const std::string_view kReportJs;

}  // namespace pathfit::app
