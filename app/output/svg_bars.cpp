#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/output/html_text.h"
#include "app/output/svg_plot.h"

namespace pathfit::app {
namespace {

constexpr double kWidth = 1060.0, kHeight = 200.0;
constexpr double kLeft = 58.0, kRight = 1048.0, kTop = 10.0, kBottom = 176.0;
constexpr double kRowHeight = 30.0;
constexpr int kNumColors = 6;

double FiniteOrZero(double value) { return std::isfinite(value) ? value : 0.0; }

std::string Open(const PlotOptions& options, double height) {
  return fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
                     kWidth,
                     height,
                     EscapeHtml(options.title));
}

std::string Rect(
    double x, double y, double width, double height, int color, const std::string& tooltip) {
  return fmt::format(
      "<rect class=\"bar s{}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\">"
      "<title>{}</title></rect>",
      color,
      x,
      y,
      std::max(width, 0.0),
      std::max(height, 0.0),
      EscapeHtml(tooltip));
}

}  // namespace

std::string SvgBars(const PlotOptions& options, const std::vector<BarGroup>& groups) {
  std::string html = "<figure class=\"plot wide\"><figcaption><b>" + EscapeHtml(options.title) +
                     "</b></figcaption>";
  if (groups.empty()) return html + "<p class=\"empty\">No data.</p></figure>";
  double low = -0.1, high = 0.1;
  for (const BarGroup& group : groups) {
    const double value = group.values.empty() ? 0.0 : FiniteOrZero(group.values.front());
    low = std::min(low, 1.1 * value);
    high = std::max(high, 1.1 * value);
  }
  const auto at = [&](double value) {
    return kBottom + (value - low) / (high - low) * (kTop - kBottom);
  };
  std::string svg = Open(options, kHeight);
  for (const double tick : LinearTicks(low, high, 4)) {
    svg += fmt::format("<path class=\"grid\" d=\"M{} {:.1f}H{}\"/>", kLeft, at(tick), kRight);
    svg += fmt::format("<text class=\"tick end\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>",
                       kLeft - 6.0,
                       at(tick) + 4.0,
                       NumberText(tick));
  }
  const double pitch = (kRight - kLeft) / static_cast<double>(groups.size());
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const BarGroup& group = groups[i];
    const double value = group.values.empty() ? 0.0 : FiniteOrZero(group.values.front());
    const double top = std::min(at(0.0), at(value));
    svg += Rect(kLeft + (static_cast<double>(i) + 0.1) * pitch,
                top,
                std::min(0.8 * pitch, 60.0),
                std::max(std::abs(at(value) - at(0.0)), 0.5),
                group.color,
                group.name);
  }
  svg += fmt::format("<path class=\"axis\" d=\"M{} {:.1f}H{}\"/>", kLeft, at(0.0), kRight);
  svg += fmt::format("<text class=\"label mid\" x=\"{}\" y=\"{}\">{}</text>",
                     0.5 * (kLeft + kRight),
                     kHeight - 6.0,
                     EscapeHtml(options.x_label));
  svg +=
      fmt::format("<text class=\"label mid\" transform=\"translate(12 {}) rotate(-90)\">{}</text>",
                  0.5 * (kTop + kBottom),
                  EscapeHtml(options.y_label));
  return html + svg + "</svg></figure>";
}

std::string SvgStackedBars(const PlotOptions& options,
                           const std::vector<std::string>& parts,
                           const std::vector<BarGroup>& groups) {
  std::string html =
      "<figure class=\"plot wide\"><figcaption><b>" + EscapeHtml(options.title) + "</b>";
  for (std::size_t k = 0; k < parts.size(); ++k) {
    html += fmt::format("<span class=\"key s{}\">{}</span>", k % kNumColors, EscapeHtml(parts[k]));
  }
  html += "</figcaption>";
  double longest = 0.0;
  for (const BarGroup& group : groups) {
    double sum = 0.0;
    for (const double value : group.values) sum += std::max(FiniteOrZero(value), 0.0);
    longest = std::max(longest, sum);
  }
  if (!(longest > 0.0)) return html + "<p class=\"empty\">No data.</p></figure>";
  constexpr double kNameWidth = 130.0;
  const double scale = (kRight - kNameWidth) / longest;
  std::string svg = Open(options, kRowHeight * static_cast<double>(groups.size()) + 4.0);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const double y = kRowHeight * static_cast<double>(i) + 4.0;
    svg += fmt::format("<text class=\"tick end\" x=\"{}\" y=\"{:.1f}\">{}</text>",
                       kNameWidth - 8.0,
                       y + 16.0,
                       EscapeHtml(groups[i].name));
    double x = kNameWidth;
    for (std::size_t k = 0; k < groups[i].values.size(); ++k) {
      const double value = std::max(FiniteOrZero(groups[i].values[k]), 0.0);
      const std::string part = k < parts.size() ? parts[k] : "";
      svg += Rect(x,
                  y,
                  scale * value,
                  kRowHeight - 8.0,
                  static_cast<int>(k) % kNumColors,
                  fmt::format("{}: {} {}", part, NumberText(value), options.x_label));
      x += scale * value;
    }
  }
  return html + svg + "</svg></figure>";
}

}  // namespace pathfit::app
