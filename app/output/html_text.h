#pragma once

#include <string>

namespace pathfit::app {

/// & < > " and apostrophe as entities; control characters other than line breaks and tabs, and
/// bytes that are not UTF-8, as U+FFFD. not UTF-8, as U+FFFD.
std::string EscapeHtml(const std::string& text);

/// Four significant digits, powers of ten with superscripts; "–" for NaN, "∞" for infinity. UTF-8,
/// nothing to escape.
std::string NumberText(double value);

/// Fixed digits after the point and a unit ("27.31 dB"); "–" when not finite.
std::string FixedText(double value, int digits, const std::string& unit);

/// Bytes as "812 kB", "3.4 MB".
std::string BytesText(double bytes);

}  // namespace pathfit::app
