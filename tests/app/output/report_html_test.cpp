#include "app/output/report_html.h"

#include <limits>

#include <gtest/gtest.h>

#include "app/output/report_sections.h"
#include "app/output/report_style.h"
#include "app/output/sha256.h"
#include "tests/app/output/html_check.h"
#include "tests/app/output/synthetic_run.h"

namespace pathfit::app {
namespace {

const std::string kNasty = "<script>alert('x')</script>&\"\x01\xff";

ReportData SomeData(int num_views, std::size_t image_bytes) {
  const optim::ObservationSet set = MakeObservations(num_views, 8, 6);
  ReportData data;
  data.run_path = "/runs/axe/x";
  data.status = "finished";
  data.record = MakeRunRecord({"pathfit", "fit", "axe.yaml"});
  data.record.name = "axe";
  AddStage(MakeStage("start", 0, 1.0, set), data.history);
  for (int step = 1; step <= 12; ++step) AddRound(MakeRound(step, 4), data.history);
  AddStage(MakeStage("colours", 4, 0.2, set), data.history);
  for (std::size_t i = 0; i < set.views.size(); ++i) {
    ReportView view;
    view.start = data.history.stages[0].report.views[i];
    view.last = data.history.stages[1].report.views[i];
    view.has_start = true;
    view.photo = view.result_fit = std::string(image_bytes, 'j');
    data.views.push_back(view);
  }
  return data;
}

/// The page is well-formed and refers to nothing outside itself.
void ExpectSound(const std::string& html) {
  EXPECT_EQ(HtmlFault(html), "");
  for (const char* reference :
       {"http:", "https:", "src=\"//", "url(", "@import", "<link", "<iframe"}) {
    EXPECT_EQ(Count(html, reference), 0) << reference;
  }
  EXPECT_EQ(Count(html, "src=\""), Count(html, "src=\"data:image/"));
  EXPECT_EQ(Count(html, "href=\""), Count(html, "href=\"#"));
  EXPECT_EQ(Count(html, " style="), 0);
  EXPECT_EQ(Count(html, " onclick="), 0);
  EXPECT_EQ(Count(html, "<script"), 1);
  EXPECT_EQ(Count(html, CspHash(ReportScript())), 1);
  EXPECT_EQ(Count(html, CspHash(ReportStyle())), 1);
  EXPECT_EQ(Count(html, "default-src 'none'"), 1);
}

TEST(ReportHtml, IsSoundWithAllSections) {
  const std::string html = BuildReportHtml(SomeData(12, 1000), {});
  ExpectSound(html);
  for (const char* id : {"stages", "views", "curves", "exposure", "timing", "reproduction"}) {
    EXPECT_EQ(Count(html, "<section id=\"" + std::string(id) + "\">"), 1) << id;
    EXPECT_EQ(Count(html, "href=\"#" + std::string(id) + "\""), 1) << id;
  }
  EXPECT_EQ(Count(html, "<article"), 3 + 8);  // all held out, the worst eight of nine fitted
}

TEST(ReportHtml, IsSoundWithAlmostNothing) {
  ReportData data;
  data.status = "failed";
  ExpectSound(BuildReportHtml(data, {}));
  data = SomeData(1, 0);
  data.history.stages.pop_back();
  data.history.rounds.resize(1);
  optim::RoundReport& round = data.history.rounds.front();
  round.cost_total = round.psnr_linear_val = round.wall_s =
      std::numeric_limits<double>::quiet_NaN();
  ExpectSound(BuildReportHtml(data, {}));
}

TEST(ReportHtml, EscapesEverythingThatComesFromTheRun) {
  ReportData data = SomeData(2, 10);
  RunRecord& record = data.record;
  data.run_path = record.name = record.reason = record.host = record.cpu = kNasty;
  record.program_version = record.build = record.config_path = kNasty;
  record.started_utc = record.ended_utc = kNasty;
  record.libraries = {{kNasty, kNasty}};
  record.assumptions = record.warnings = record.attributions = {kNasty};
  record.inputs = {{kNasty, 1, kNasty}};
  record.sessions.push_back({{kNasty, "a b'c"}, 1, kNasty, kNasty, 3, kNasty});
  data.config = data.resolved_config = kNasty;
  ParameterSummary& parameter = data.history.parameters.emplace_back();
  parameter.name = parameter.unit = kNasty;
  parameter.num_at_bound = 1;
  for (StageEntry& entry : data.history.stages) {
    entry.report.kept = entry.report.stop_reason = kNasty;
    for (optim::ViewReport& view : entry.report.views) view.name = kNasty;
  }
  data.history.stages.back().report.stage = kNasty;
  for (ReportView& view : data.views) view.last.name = kNasty;
  for (optim::RoundReport& round : data.history.rounds) round.stage = round.linear_solver = kNasty;
  const std::string html = BuildReportHtml(data, {});
  ExpectSound(html);
  EXPECT_EQ(Count(html, "alert('x')"), 0);
  EXPECT_EQ(html.find('\x01'), std::string::npos);
  EXPECT_EQ(html.find('\xff'), std::string::npos);
}

TEST(ReportHtml, StaysBelowItsSizeAndSaysSo) {
  const ReportData data = SomeData(60, 200000);
  const ReportOptions options;
  const std::string html = BuildReportHtml(data, options);
  EXPECT_LE(html.size(), options.max_bytes);
  EXPECT_GT(html.size(), options.max_bytes * 9 / 10);
  EXPECT_EQ(Count(html, "views were left out to keep this file below"), 1);
  ExpectSound(html);
  EXPECT_EQ(Count(BuildReportHtml(SomeData(12, 1000), {}), "were left out"), 0);
}

TEST(ReportHtml, ShowsTheWorstViewsFirst) {
  ReportData data = SomeData(12, 10);
  data.views[7].last.psnr_srgb = 3.0;
  data.views[8].last.psnr_srgb = 4.0;
  const std::string html = BuildReportHtml(data, {});
  EXPECT_LT(html.find(ViewName(8)), html.find(ViewName(4)));
  EXPECT_LT(html.find("<h3>" + ViewName(7)), html.find("<h3>" + ViewName(1)));
}

TEST(DerivedWarnings, NameWhatAPersonShouldSee) {
  ReportData data = SomeData(8, 10);
  EXPECT_TRUE(DerivedWarnings(data.history).empty());
  optim::StageReport& last = data.history.stages.back().report;
  last.psnr_srgb_val = last.psnr_srgb_fit - 3.0;
  ParameterSummary& parameter = data.history.parameters.emplace_back();
  parameter.name = "paint.roughness";
  parameter.num_at_bound = 1;
  data.history.rounds.back().noise_relative = 0.9;
  EXPECT_EQ(DerivedWarnings(data.history).size(), 3U);
  for (optim::ViewReport& view : last.views) view.validation = false;
  EXPECT_NE(DerivedWarnings(data.history).front().find("No view was held out"), std::string::npos);
}

}  // namespace
}  // namespace pathfit::app
