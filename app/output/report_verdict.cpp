#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "app/output/html_text.h"
#include "app/output/report_sections.h"
#include "app/output/utc_time.h"

namespace pathfit::app {
namespace {

constexpr double kOverfitDb = 2.0;
constexpr double kNoiseShare = 0.7;
constexpr double kVisibleLossDb = 0.05;

std::string StatusSentence(const ReportData& data) {
  const std::string& reason = data.record.reason;
  const std::string why = reason.empty() ? "" : ": " + reason;
  if (data.status == "finished") return "The fit finished" + why + ".";
  if (data.status == "stopped") {
    return "The fit was stopped" + why +
           ". What is shown is the last stage that ended. It can be continued with: pathfit "
           "resume " +
           data.run_path;
  }
  if (data.status == "failed") {
    return "The fit failed" + why + ". What is shown is the last state that was kept.";
  }
  if (data.status == "killed") {
    return "The process ended without a word (killed, or the machine stopped). It can be "
           "continued with: pathfit resume " +
           data.run_path;
  }
  return "The fit was running when this report was written; it shows the stages that are done.";
}

std::string Tile(const std::string& label, const std::string& value, const std::string& below) {
  return "<div class=\"tile\"><span>" + label + "</span><b>" + value + "</b><span>" + below +
         "</span></div>";
}

/// Final value, and below it where it started and by how much it changed.
std::string ChangeTile(const std::string& label,
                       const std::optional<double>& start,
                       double last,
                       int digits,
                       const std::string& unit) {
  const std::string value = FixedText(last, digits, unit);
  if (!start) return Tile(label, value, "");
  const double change = last - *start;
  const std::string sign = change > 0.0 ? "+" : "";
  return Tile(label,
              value,
              fmt::format("from {} <i class=\"{}\">{}{}</i>",
                          FixedText(*start, digits, ""),
                          change < 0.0 ? "down" : "up",
                          sign,
                          FixedText(change, digits, unit)));
}

std::string QualityTiles(const FitHistory& history) {
  const optim::StageReport* start = StartReport(history);
  const optim::StageReport* last = LastReport(history);
  if (last == nullptr) return "";
  const bool has_start = start != nullptr && start != last;
  const auto tile =
      [&](const char* label, double optim::StageReport::*quality, int digits, const char* unit) {
        const std::optional<double> before =
            has_start ? std::optional<double>(start->*quality) : std::nullopt;
        return ChangeTile(label, before, last->*quality, digits, unit);
      };
  std::string html;
  if (HasValidation(*last)) {
    html += tile("Held-out views, PSNR (sRGB)", &optim::StageReport::psnr_srgb_val, 2, "dB");
    html += tile("Held-out views, mask IoU", &optim::StageReport::iou_val, 4, "");
  }
  html += tile("Fitted views, PSNR (sRGB)", &optim::StageReport::psnr_srgb_fit, 2, "dB");
  return html + tile("Fitted views, mask IoU", &optim::StageReport::iou_fit, 4, "");
}

double WallSeconds(const ReportData& data) {
  const double rounds = data.history.rounds.empty() ? 0.0 : data.history.rounds.back().wall_s;
  return std::isfinite(data.record.wall_s) && data.record.wall_s > 0.0 ? data.record.wall_s
                                                                       : rounds;
}

}  // namespace

std::string ChangeText(
    bool has_start, double start, double last, int digits, const std::string& unit) {
  const std::string end = FixedText(last, digits, unit);
  return has_start ? FixedText(start, digits, "") + " → " + end : end;
}

std::vector<std::string> DerivedWarnings(const FitHistory& history) {
  std::vector<std::string> warnings;
  const optim::StageReport* last = LastReport(history);
  if (last != nullptr && HasValidation(*last)) {
    if (last->psnr_srgb_val < last->psnr_srgb_fit - kOverfitDb) {
      warnings.push_back(
          fmt::format("Held-out views are {:.1f} dB worse than fitted ones: the result does not "
                      "generalise to views it was not fitted to.",
                      last->psnr_srgb_fit - last->psnr_srgb_val));
    }
    for (std::size_t i = 1; i < history.stages.size(); ++i) {
      const double lost =
          history.stages[i - 1].report.psnr_srgb_val - history.stages[i].report.psnr_srgb_val;
      if (lost > kVisibleLossDb) {
        warnings.push_back(fmt::format("Stage {} made the held-out views {:.2f} dB worse.",
                                       history.stages[i].report.stage,
                                       lost));
      }
    }
  }
  if (last != nullptr && !HasValidation(*last)) {
    warnings.emplace_back("No view was held out, so nothing says how the result generalises.");
  }
  for (const ParameterSummary& parameter : history.parameters) {
    if (parameter.num_at_bound > 0 && parameter.num_scalars == 1 && !parameter.hold) {
      warnings.push_back(parameter.name + " ended at its bound.");
    }
  }
  if (!history.rounds.empty() && history.rounds.back().noise_relative > kNoiseShare) {
    warnings.push_back(fmt::format("In the last round {:.0f} % of the residual was sampling noise.",
                                   100.0 * history.rounds.back().noise_relative));
  }
  return warnings;
}

std::string VerdictSection(const ReportData& data) {
  const FitHistory& history = data.history;
  std::string html = "<section class=\"card verdict " + data.status + "\"><span class=\"badge\">" +
                     data.status + "</span><p>" + EscapeHtml(StatusSentence(data)) + "</p>";
  html += "<div class=\"tiles\">" + QualityTiles(history);
  const std::string rounds =
      history.rounds.empty() ? "" : std::to_string(history.rounds.back().step) + " rounds";
  html += Tile("Wall time", DurationText(WallSeconds(data)), rounds);
  html += "</div>";
  std::vector<std::string> warnings = data.record.warnings;
  for (std::string& warning : DerivedWarnings(history)) warnings.push_back(std::move(warning));
  if (!warnings.empty()) {
    html += "<ul class=\"warnings\">";
    for (const std::string& warning : warnings) html += "<li>" + EscapeHtml(warning) + "</li>";
    html += "</ul>";
  }
  return html + "</section>";
}

std::string StageTableSection(const ReportData& data) {
  if (data.history.stages.empty()) return "";
  std::string html =
      "<section id=\"stages\"><h2>Stages</h2><div class=\"card scroll\"><table><thead><tr>"
      "<th>Stage</th><th>Rounds</th><th>Cost, before → after</th>"
      "<th>PSNR sRGB<br>fitted</th><th>PSNR sRGB<br>held out</th>"
      "<th>PSNR linear<br>fitted</th><th>PSNR linear<br>held out</th>"
      "<th>IoU<br>fitted</th><th>IoU<br>held out</th><th>Kept</th>"
      "<th class=\"left\">Ended because</th></tr></thead><tbody>";
  for (const StageEntry& entry : data.history.stages) {
    const optim::StageReport& stage = entry.report;
    const bool validation = HasValidation(stage);
    const bool rounds = stage.rounds > 0;
    const auto held_out = [&](double value, int digits, const char* unit) {
      return validation ? FixedText(value, digits, unit) : "–";
    };
    html += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
        "<td>{}</td><td>{}</td><td>{}</td><td class=\"left wrap\">{}</td></tr>",
        EscapeHtml(stage.stage),
        rounds ? std::to_string(stage.rounds) : "–",
        rounds ? NumberText(stage.cost_before) + " → " + NumberText(stage.cost_after) : "–",
        FixedText(stage.psnr_srgb_fit, 2, "dB"),
        held_out(stage.psnr_srgb_val, 2, "dB"),
        FixedText(stage.psnr_linear_fit, 2, "dB"),
        held_out(stage.psnr_linear_val, 2, "dB"),
        FixedText(stage.iou_fit, 4, ""),
        held_out(stage.iou_val, 4, ""),
        EscapeHtml(stage.kept),
        EscapeHtml(stage.stop_reason));
  }
  return html +
         "</tbody></table><p class=\"note\">PSNR is measured inside the mask, after the sRGB curve "
         "or on linear values as named; means over views. Costs before and after a stage use the "
         "same samples.</p></div></section>";
}

}  // namespace pathfit::app
