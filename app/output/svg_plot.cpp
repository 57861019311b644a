#include "app/output/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "app/output/html_text.h"
#include "renderer/core/check.h"

namespace pathfit::app {
namespace {

constexpr double kWidth = 520.0, kHeight = 250.0;
constexpr double kLeft = 58.0, kRight = 508.0, kTop = 16.0, kBottom = 212.0;
constexpr std::size_t kMaxPoints = 2000;
constexpr double kMostDrawable = 1e150;  ///< keeps differences of values finite
constexpr double kColumnsPerLetter = 6.2;

bool Drawable(double value, bool log) {
  return std::isfinite(value) && std::abs(value) < kMostDrawable && (!log || value > 1e-150);
}

/// Maps values to the picture: the interval [low, high] to [begin, end].
struct Axis {
  double low = 0.0, high = 1.0;
  double begin = 0.0, end = 1.0;
  bool log = false;

  [[nodiscard]] double At(double value) const {
    const double t = log ? (std::log(value) - std::log(low)) / (std::log(high) - std::log(low))
                         : (value - low) / (high - low);
    return begin + t * (end - begin);
  }
};

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void Add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] bool Empty() const { return low > high; }
};

Axis MakeXAxis(const Range& range) {
  const bool single = range.high - range.low < 1e-12 * std::max(1.0, std::abs(range.high));
  return {
      single ? range.low - 1.0 : range.low, single ? range.high + 1.0 : range.high, kLeft, kRight};
}

Axis MakeYAxis(const Range& range, const PlotOptions& options) {
  Axis axis{
      .low = range.low, .high = range.high, .begin = kBottom, .end = kTop, .log = options.log_y};
  if (options.log_y) {
    const double least = 0.3;  // decades: a flat curve is drawn in the middle, not as noise
    const double missing = std::max(0.0, least - std::log10(range.high / range.low));
    const double pad = std::pow(10.0, 0.5 * missing + 0.04 * std::log10(range.high / range.low));
    axis.low = range.low / pad;
    axis.high = range.high * pad;
    return axis;
  }
  const double span = range.high - range.low;
  const double pad =
      span > 1e-9 * std::abs(range.high) ? 0.06 * span : 0.05 * std::max(std::abs(range.high), 0.2);
  axis.low = options.y_from_zero && range.low >= 0.0 ? 0.0 : range.low - pad;
  axis.high = range.high + pad;
  return axis;
}

std::string Text(double x, double y, const std::string& css, const std::string& text) {
  return fmt::format(
      "<text class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>", css, x, y, EscapeHtml(text));
}

std::string GridSvg(const Axis& x, const Axis& y, const PlotOptions& options) {
  std::string svg;
  const std::vector<double> y_ticks =
      y.log ? LogTicks(y.low, y.high) : LinearTicks(y.low, y.high, 5);
  for (const double tick : y_ticks) {
    svg += fmt::format("<path class=\"grid\" d=\"M{} {:.1f}H{}\"/>", kLeft, y.At(tick), kRight);
    svg += Text(kLeft - 6.0, y.At(tick) + 4.0, "tick end", NumberText(tick));
  }
  for (const double tick : LinearTicks(x.low, x.high, 6)) {
    svg += Text(x.At(tick), kBottom + 16.0, "tick mid", NumberText(tick));
  }
  svg += fmt::format("<path class=\"axis\" d=\"M{} {}V{}H{}\"/>", kLeft, kTop, kBottom, kRight);
  svg += Text(0.5 * (kLeft + kRight), kHeight - 4.0, "label mid", options.x_label);
  svg +=
      fmt::format("<text class=\"label mid\" transform=\"translate(12 {}) rotate(-90)\">{}</text>",
                  0.5 * (kTop + kBottom),
                  EscapeHtml(options.y_label));
  return svg;
}

/// Each mark's label stands between its line and the next one, if there is room.
std::string StageLinesSvg(const Axis& x, const std::vector<PlotMark>& marks) {
  std::string svg;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (!Drawable(marks[i].x, false) || marks[i].x > x.high) continue;
    const double at = std::max(x.At(marks[i].x), kLeft);
    const double end = i + 1 < marks.size() ? std::min(x.At(marks[i + 1].x), kRight) : kRight;
    if (at > kLeft + 0.5) {
      svg += fmt::format("<path class=\"stage\" d=\"M{:.1f} {}V{}\"/>", at, kTop, kBottom);
    }
    if (kColumnsPerLetter * static_cast<double>(marks[i].label.size()) < end - at) {
      svg += Text(at + 3.0, kTop - 4.0, "tick", marks[i].label);
    }
  }
  return svg;
}

std::string Dot(double x, double y, int color) {
  return fmt::format(
      "<circle class=\"dot s{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.6\"/>", color, x, y);
}

std::string SeriesSvg(const Axis& x, const Axis& y, const PlotSeries& series) {
  const std::size_t stride = series.x.size() / kMaxPoints + 1;
  std::string path, dots;
  std::size_t run = 0;
  double last_x = 0.0, last_y = 0.0;
  const auto end_run = [&] {
    if (run == 1) dots += Dot(last_x, last_y, series.color);
    run = 0;
  };
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (i % stride != 0 && i + 1 != series.x.size()) continue;
    if (!Drawable(series.x[i], false) || !Drawable(series.y[i], y.log)) {
      end_run();
      continue;
    }
    last_x = x.At(series.x[i]);
    last_y = y.At(series.y[i]);
    path += fmt::format("{}{:.1f} {:.1f}", run == 0 ? "M" : "L", last_x, last_y);
    ++run;
  }
  end_run();
  std::string svg;
  if (!path.empty()) {
    svg = fmt::format("<path class=\"line s{}{}\" d=\"{}\"/>",
                      series.color,
                      series.dashed ? " dashed" : "",
                      path);
  }
  return svg + dots;
}

std::string CrossesSvg(const Axis& x, const Axis& y, const PlotOptions& options) {
  std::string svg;
  for (const auto& [cross_x, cross_y] : options.crosses) {
    if (!Drawable(cross_x, false) || !Drawable(cross_y, y.log)) continue;
    svg += fmt::format("<path class=\"cross\" d=\"M{0:.1f} {1:.1f}l8 8m0 -8l-8 8\"/>",
                       x.At(cross_x) - 4.0,
                       y.At(cross_y) - 4.0);
  }
  return svg;
}

std::string Caption(const PlotOptions& options, const std::vector<PlotSeries>& series) {
  std::string html = "<figcaption><b>" + EscapeHtml(options.title) + "</b>";
  for (const PlotSeries& one : series) {
    if (one.name.empty()) continue;
    html += fmt::format("<span class=\"key s{}{}\">{}</span>",
                        one.color,
                        one.dashed ? " dashed" : "",
                        EscapeHtml(one.name));
  }
  if (!options.crosses.empty()) html += "<span class=\"key reject\">✕ rejected step</span>";
  return html + "</figcaption>";
}

}  // namespace

std::vector<double> LinearTicks(double low, double high, int about) {
  const double span = high - low;
  if (!(span > 0.0) || !std::isfinite(span) || about < 1) return {low};
  const double raw = span / about;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10.0 * power;
  for (const double nice : {1.0, 2.0, 5.0}) {
    if (nice * power >= raw * (1.0 - 1e-9)) {
      step = nice * power;
      break;
    }
  }
  std::vector<double> ticks;
  const double first = std::ceil(low / step - 1e-9);
  for (int i = 0; (first + i) * step <= high + 1e-9 * span; ++i) {
    ticks.push_back((first + i) * step);
  }
  return ticks;
}

std::vector<double> LogTicks(double low, double high) {
  const int first = static_cast<int>(std::floor(std::log10(low)));
  const int last = static_cast<int>(std::ceil(std::log10(high)));
  const int stride = std::max(1, (last - first) / 6);
  std::vector<double> ticks;
  for (int exponent = first; exponent <= last; exponent += stride) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      if (digit > 1.0 && last - first > 3) break;
      const double tick = digit * std::pow(10.0, exponent);
      if (tick >= low && tick <= high) ticks.push_back(tick);
    }
  }
  return ticks.size() < 2 ? LinearTicks(low, high, 4) : ticks;
}

std::string SvgLinePlot(const PlotOptions& options, const std::vector<PlotSeries>& series) {
  Range x_range, y_range;
  for (const PlotSeries& one : series) {
    PATHFIT_CHECK(one.x.size() == one.y.size());
    for (std::size_t i = 0; i < one.x.size(); ++i) {
      if (!Drawable(one.x[i], false) || !Drawable(one.y[i], options.log_y)) continue;
      x_range.Add(one.x[i]);
      y_range.Add(one.y[i]);
    }
  }
  const std::string caption = "<figure class=\"plot\">" + Caption(options, series);
  if (x_range.Empty()) return caption + "<p class=\"empty\">No data.</p></figure>";
  for (const auto& [cross_x, cross_y] : options.crosses) {
    if (Drawable(cross_x, false) && Drawable(cross_y, options.log_y)) {
      x_range.Add(cross_x);
      y_range.Add(cross_y);
    }
  }
  const Axis x = MakeXAxis(x_range);
  const Axis y = MakeYAxis(y_range, options);
  std::string svg = fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
                                kWidth,
                                kHeight,
                                EscapeHtml(options.title));
  svg += GridSvg(x, y, options) + StageLinesSvg(x, options.stage_lines);
  for (const PlotSeries& one : series) svg += SeriesSvg(x, y, one);
  return caption + svg + CrossesSvg(x, y, options) + "</svg></figure>";
}

}  // namespace pathfit::app
