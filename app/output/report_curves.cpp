#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "app/output/html_text.h"
#include "app/output/report_sections.h"
#include "app/output/svg_plot.h"
#include "app/output/utc_time.h"

namespace pathfit::app {
namespace {

using optim::RoundReport;

template <class Field>
PlotSeries Series(const FitHistory& history, std::string name, int color, Field field) {
  PlotSeries series;
  series.name = std::move(name);
  series.color = color;
  for (const RoundReport& round : history.rounds) {
    series.x.push_back(round.step);
    series.y.push_back(static_cast<double>(field(round)));
  }
  return series;
}

/// A line where each stage begins, half a step before its first round.
std::vector<PlotMark> StageLines(const FitHistory& history) {
  std::vector<PlotMark> marks;
  std::string stage;
  for (const RoundReport& round : history.rounds) {
    if (!marks.empty() && round.stage == stage) continue;
    stage = round.stage;
    marks.push_back({round.step - 0.5, stage});
  }
  return marks;
}

std::vector<std::pair<double, double>> RejectedSteps(const FitHistory& history) {
  std::vector<std::pair<double, double>> crosses;
  for (const RoundReport& round : history.rounds) {
    if (!round.accepted) crosses.emplace_back(round.step, round.cost_total);
  }
  return crosses;
}

bool AnyPositive(const PlotSeries& series) {
  return std::any_of(series.y.begin(), series.y.end(), [](double y) { return y > 0.0; });
}

struct StageTimes {
  std::string stage;
  int rounds = 0, max_spp = 0;
  double wall_s = 0.0, render_s = 0.0, jacobian_s = 0.0, linear_s = 0.0;
  double jacobian_mb = 0.0, peak_rss_mb = 0.0;
  std::string linear_solver;
};

std::vector<StageTimes> TimesByStage(const FitHistory& history) {
  std::vector<StageTimes> stages;
  double last_wall = 0.0;
  for (const RoundReport& round : history.rounds) {
    if (stages.empty() || stages.back().stage != round.stage) {
      stages.emplace_back().stage = round.stage;
    }
    StageTimes& times = stages.back();
    ++times.rounds;
    times.max_spp = std::max(times.max_spp, round.spp);
    times.wall_s += std::max(round.wall_s - last_wall, 0.0);
    times.render_s += round.render_s;
    times.jacobian_s += round.jacobian_s;
    times.linear_s += round.linear_s;
    times.jacobian_mb = std::max(times.jacobian_mb, round.jacobian_mb);
    times.peak_rss_mb = std::max(times.peak_rss_mb, round.peak_rss_mb);
    times.linear_solver = round.linear_solver;
    last_wall = round.wall_s;
  }
  return stages;
}

std::string TimingTable(const std::vector<StageTimes>& stages) {
  std::string html =
      "<div class=\"card scroll\"><table><thead><tr><th>Stage</th><th>Rounds</th><th>Wall</th>"
      "<th>Per round</th><th>Images</th><th>Jacobian</th><th>Linear solve</th>"
      "<th>Largest spp</th><th>Jacobian size</th><th>Peak memory</th><th>Linear solver</th>"
      "</tr></thead><tbody>";
  for (const StageTimes& times : stages) {
    html += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
        "<td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
        EscapeHtml(times.stage),
        times.rounds,
        DurationText(times.wall_s),
        DurationText(times.wall_s / times.rounds),
        DurationText(times.render_s),
        DurationText(times.jacobian_s),
        DurationText(times.linear_s),
        times.max_spp,
        BytesText(times.jacobian_mb * 1e6),
        BytesText(times.peak_rss_mb * 1e6),
        EscapeHtml(times.linear_solver));
  }
  return html + "</tbody></table></div>";
}

}  // namespace

std::string CurvesSection(const FitHistory& history) {
  if (history.rounds.empty()) return "";
  const auto options = [&](const char* title, const char* y_label) {
    PlotOptions plot;
    plot.title = title;
    plot.x_label = "step";
    plot.y_label = y_label;
    plot.stage_lines = StageLines(history);
    return plot;
  };
  PlotOptions cost = options("Cost", "cost, log scale");
  cost.log_y = true;
  cost.crosses = RejectedSteps(history);
  std::vector<PlotSeries> costs = {
      Series(history, "total", 0, [](const RoundReport& r) { return r.cost_total; })};
  const std::vector<PlotSeries> parts = {
      Series(history, "colours", 1, [](const RoundReport& r) { return r.cost_image; }),
      Series(history, "silhouettes", 2, [](const RoundReport& r) { return r.cost_silhouette; }),
      Series(history, "priors", 3, [](const RoundReport& r) { return r.cost_priors; })};
  std::copy_if(parts.begin(), parts.end(), std::back_inserter(costs), AnyPositive);

  std::vector<PlotSeries> psnr = {
      Series(history, "fitted", 0, [](const RoundReport& r) { return r.psnr_linear_fit; })};
  std::vector<PlotSeries> iou = {
      Series(history, "fitted", 0, [](const RoundReport& r) { return r.iou_fit; })};
  const optim::StageReport* last = LastReport(history);
  if (last == nullptr || HasValidation(*last)) {
    psnr.push_back(
        Series(history, "held out", 1, [](const RoundReport& r) { return r.psnr_linear_val; }));
    iou.push_back(Series(history, "held out", 1, [](const RoundReport& r) { return r.iou_val; }));
  }
  PlotOptions spp = options("Samples per pixel", "spp");
  spp.y_from_zero = true;
  PlotOptions noise = options("Sampling noise in the residual", "share of rms residual");
  noise.y_from_zero = true;
  PlotOptions steps = options("Step length", "norm, log scale");
  steps.log_y = true;

  std::string html = "<section id=\"curves\"><h2>Curves</h2><div class=\"plots\">";
  html += SvgLinePlot(cost, costs);
  html += SvgLinePlot(options("PSNR inside the mask, linear values", "dB"), psnr);
  html += SvgLinePlot(options("Mask IoU", "IoU"), iou);
  html += SvgLinePlot(
      steps,
      {Series(history, "step", 0, [](const RoundReport& r) { return r.step_norm; }),
       Series(history, "trust radius", 1, [](const RoundReport& r) { return r.trust_radius; })});
  html += SvgLinePlot(spp, {Series(history, "", 0, [](const RoundReport& r) { return r.spp; })});
  html += SvgLinePlot(
      noise, {Series(history, "", 0, [](const RoundReport& r) { return r.noise_relative; })});
  return html +
         "</div><p class=\"note\">Every round has its own samples, so costs of neighbouring rounds "
         "differ by noise as well. Dotted lines: beginnings of stages.</p></section>";
}

std::string TimingSection(const FitHistory& history) {
  const std::vector<StageTimes> stages = TimesByStage(history);
  if (stages.empty()) return "";
  std::vector<BarGroup> groups;
  for (const StageTimes& times : stages) {
    const double known = times.render_s + times.jacobian_s + times.linear_s;
    groups.push_back(
        {times.stage,
         {times.render_s, times.jacobian_s, times.linear_s, std::max(times.wall_s - known, 0.0)},
         0});
  }
  PlotOptions options;
  options.title = "Seconds by stage";
  options.x_label = "s";
  return "<section id=\"timing\"><h2>Time and memory</h2>" +
         SvgStackedBars(options, {"images", "Jacobian", "linear solve", "other"}, groups) +
         TimingTable(stages) + "</section>";
}

}  // namespace pathfit::app
