#include "app/output/report_html.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "app/output/html_text.h"
#include "app/output/report_sections.h"
#include "app/output/report_style.h"
#include "app/output/sha256.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app {
namespace {

std::string Head(const std::string& title) {
  // Only the style sheet and the script with these hashes, and embedded pictures.
  const std::string policy = fmt::format(
      "default-src 'none'; img-src data:; style-src '{}'; script-src '{}'; "
      "base-uri 'none'; form-action 'none'",
      CspHash(ReportStyle()),
      CspHash(ReportScript()));
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
      "<meta name=\"generator\" content=\"pathfit\"><title>{} – pathfit report</title>"
      "<style>{}</style></head>\n",
      policy,
      EscapeHtml(title),
      ReportStyle());
}

std::string Header(const ReportData& data) {
  const RunRecord& record = data.record;
  std::string line = data.run_path + " · started " + record.started_utc;
  if (!record.ended_utc.empty()) line += " · ended " + record.ended_utc;
  return "<header><h1>" + EscapeHtml(record.name) + "</h1><p class=\"sub\">" + EscapeHtml(line) +
         "</p></header>";
}

/// Links to the sections that are there.
std::string Navigation(const std::string& body) {
  std::string html = "<nav aria-label=\"Sections\">";
  for (const auto& [id, name] : {std::pair{"stages", "Stages"},
                                 std::pair{"views", "Views"},
                                 std::pair{"curves", "Curves"},
                                 std::pair{"parameters", "Parameters"},
                                 std::pair{"exposure", "Exposure"},
                                 std::pair{"environment", "Environment light"},
                                 std::pair{"timing", "Time and memory"},
                                 std::pair{"assumptions", "Assumptions"},
                                 std::pair{"attribution", "Attribution"},
                                 std::pair{"reproduction", "Reproduction"}}) {
    if (body.find(fmt::format("<section id=\"{}\">", id)) == std::string::npos) continue;
    html += fmt::format("<a href=\"#{}\">{}</a>", id, name);
  }
  return html + "</nav>";
}

/// Held-out views first, each kind from the worst to the best; only the worst of the fitted ones.
std::vector<const ReportView*> ChosenViews(const ReportData& data, int max_fitted) {
  std::vector<const ReportView*> views;
  for (const ReportView& view : data.views) views.push_back(&view);
  std::stable_sort(views.begin(), views.end(), [](const ReportView* a, const ReportView* b) {
    if (a->last.validation != b->last.validation) return a->last.validation;
    return a->last.psnr_srgb < b->last.psnr_srgb;
  });
  const auto first_fitted = std::find_if(
      views.begin(), views.end(), [](const ReportView* view) { return !view->last.validation; });
  const auto num_fitted = views.end() - first_fitted;
  if (num_fitted > max_fitted)
    views.resize(views.size() - static_cast<std::size_t>(num_fitted - max_fitted));
  return views;
}

std::string ViewsNote(const ReportData& data,
                      const std::vector<const ReportView*>& shown,
                      std::size_t dropped,
                      std::size_t max_bytes) {
  const auto num_held_out = std::count_if(
      data.views.begin(), data.views.end(), [](const ReportView& v) { return v.last.validation; });
  const auto shown_held_out = std::count_if(
      shown.begin(), shown.end(), [](const ReportView* v) { return v->last.validation; });
  std::string note = fmt::format(
      "{} of {} held-out views and the {} worst of {} fitted ones, by PSNR of the sRGB values.",
      shown_held_out,
      num_held_out,
      static_cast<std::ptrdiff_t>(shown.size()) - shown_held_out,
      static_cast<std::ptrdiff_t>(data.views.size()) - num_held_out);
  if (dropped > 0) {
    note += fmt::format(" {} views were left out to keep this file below {}.",
                        dropped,
                        BytesText(static_cast<double>(max_bytes)));
  }
  return note;
}

/// As many of the chosen views as fit into `budget` bytes, in their order.
std::string ViewsSection(const ReportData& data, const ReportOptions& options, std::size_t used) {
  std::vector<const ReportView*> chosen = ChosenViews(data, options.max_fitted_views);
  if (chosen.empty()) return "";
  const std::string stage = LastReport(data.history)->stage;
  constexpr std::size_t kIntroductionBytes = 4000;
  std::size_t total = used + kIntroductionBytes;
  std::string articles;
  std::size_t shown = 0;
  for (; shown < chosen.size(); ++shown) {
    const std::string article = ViewArticle(*chosen[shown], stage);
    if (total + article.size() > options.max_bytes) break;
    total += article.size();
    articles += article;
  }
  const std::size_t dropped = chosen.size() - shown;
  chosen.resize(shown);
  return ViewsIntroduction(ViewsNote(data, chosen, dropped, options.max_bytes)) + articles +
         "</section>";
}

}  // namespace

std::string BuildReportHtml(const ReportData& data, const ReportOptions& options) {
  const std::string head = Head(data.record.name);
  const std::string top = Header(data) + VerdictSection(data);
  const std::string stages = StageTableSection(data);
  const std::string rest = CurvesSection(data.history) + ParametersSection(data.history) +
                           ExposureSection(data.history) + EnvironmentSection(data) +
                           TimingSection(data.history) + AssumptionsSection(data.record) +
                           ReproductionSection(data);
  const std::string script = "<script>" + std::string(ReportScript()) + "</script>";
  const std::size_t fixed = head.size() + top.size() + stages.size() + rest.size() + script.size();
  const std::string body = stages + ViewsSection(data, options, fixed) + rest;
  return head + "<body><main>" + top + Navigation(body) + body + "</main>" + script +
         "</body></html>\n";
}

void WriteReport(const RunDirectory& run, const ReportOptions& options) {
  renderer::WriteFileAtomically(run.Report(), BuildReportHtml(LoadReportData(run), options));
}

}  // namespace pathfit::app
