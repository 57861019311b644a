#pragma once

#include <string_view>

namespace pathfit::app {

/// Files of app/output/report/, put into the program when it is built.
std::string_view ReportHtml();
std::string_view ReportCss();
std::string_view ReportJs();

}  // namespace pathfit::app
