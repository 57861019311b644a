#pragma once

#include <string_view>

namespace pathfit::app {

/// Style sheet and script of the report, embedded and allowed by their hashes.
std::string_view ReportStyle();
std::string_view ReportScript();

}  // namespace pathfit::app
