#pragma once

#include <string>
#include <vector>

namespace pathfit::app {

/// One curve. Points that are not finite (or, on a log axis, not positive) interrupt the line.
struct PlotSeries {
  std::string name;
  std::vector<double> x, y;  ///< same length
  int color = 0;             ///< class s0 ... s5 of the page's style sheet
  bool dashed = false;
};

struct PlotMark {
  double x = 0.0;
  std::string label;
};

struct PlotOptions {
  std::string title;  ///< also what a screen reader says
  std::string x_label;
  std::string y_label;
  bool log_y = false;
  bool y_from_zero = false;
  std::vector<PlotMark> stage_lines;               ///< vertical lines
  std::vector<std::pair<double, double>> crosses;  ///< rejected steps
};

/// A line chart as inline SVG with a view box: classes only, no colours and no style attributes, so
/// that the page decides and a strict content security policy holds. Without any drawable point it
/// says so in words.
std::string SvgLinePlot(const PlotOptions& options, const std::vector<PlotSeries>& series);

struct BarGroup {
  std::string name;            ///< tooltip
  std::vector<double> values;  ///< stacked, or one value that may be negative
  int color = 0;               ///< of the first value; the others count on
};

/// Vertical bars from zero, one per group; with one value each they may point down.
std::string SvgBars(const PlotOptions& options, const std::vector<BarGroup>& groups);

/// Horizontal stacked bars with the group's name on the left; values >= 0.
std::string SvgStackedBars(const PlotOptions& options,
                           const std::vector<std::string>& parts,
                           const std::vector<BarGroup>& groups);

/// Round numbers that cover [low, high], at least two.
std::vector<double> LinearTicks(double low, double high, int about);
/// Powers of ten (and 2, 5 where few) in [low, high], both positive.
std::vector<double> LogTicks(double low, double high);

}  // namespace pathfit::app
