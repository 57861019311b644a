#include "app/output/report.h"

#include <limits>

#include <gtest/gtest.h>

#include "app/output/sha256.h"
#include "tests/app/output/html_check.h"
#include "tests/app/output/synthetic_run.h"

namespace pathfit::app::report_test {
namespace {

const std::string kNasty = "</script><script>alert('x')</script><!--&\"{{data}}\x01\xff";

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
  const std::string jpeg(image_bytes, 'j');
  data.view_pictures.assign(set.views.size(), {{"photo", jpeg}, {"result", jpeg}});
  return data;
}

/// The page is well-formed, refers to nothing outside itself, and holds this JSON.
void ExpectSound(const Json& json) {
  std::string html = ReportPage(json);
  EXPECT_EQ(HtmlFault(html), "");
  if (json.contains("model") && json.at("model").is_object() &&
      !json["model"]["result"].is_null()) {
    // The 3-D library can load pictures and files, which the page's policy does not let it.
    const std::string library = "<script id=\"three\">" + std::string(ThreeJs()) + "</script>";
    EXPECT_EQ(Count(html, library), 1);
    EXPECT_EQ(Count(html, CspHash(ThreeJs())), 1);
    html.erase(html.find(library), library.size());
  }
  EXPECT_EQ(html.find(ThreeJs()), std::string::npos) << "only where there is a model";
  for (const char* reference : {"https:",
                                " src=",
                                " href=",
                                "url(",
                                "@import",
                                "import(",
                                "fetch(",
                                "XMLHttp",
                                "innerHTML",
                                "<link",
                                "<iframe",
                                " style=",
                                " onclick="}) {
    EXPECT_EQ(Count(html, reference), 0) << reference;
  }
  EXPECT_EQ(Count(html, "http:"), 1) << "the name of SVG's elements";
  EXPECT_EQ(Count(html, "<script"), 2);
  EXPECT_EQ(Count(html, "</script>"), 2);
  EXPECT_EQ(Count(html, CspHash(ReportJs())), 1);
  EXPECT_EQ(Count(html, CspHash(ReportCss())), 1);
  EXPECT_EQ(Count(html, "default-src 'none'"), 1);
  const std::string begin = "<script type=\"application/json\" id=\"data\">";
  const std::size_t at = html.find(begin) + begin.size();
  const std::string embedded = html.substr(at, html.find("</script>", at) - at);
  EXPECT_EQ(embedded.find('<'), std::string::npos);
  EXPECT_EQ(JsonText(Json::parse(embedded)), JsonText(Json::parse(JsonText(json))));
}

TEST(Report, HasAllThatAPageDraws) {
  const Json json = ReportJson(SomeData(12, 1000), {});
  ExpectSound(json);
  EXPECT_EQ(json.at("run").at("name"), "axe");
  EXPECT_EQ(json.at("sentence"), "The fit finished.");
  EXPECT_EQ(json.at("history").at("rounds").size(), 12U);
  EXPECT_EQ(json.at("history").at("stages").size(), 2U);
  EXPECT_EQ(json.at("views").size(), 3U + 8U) << "all held out, the worst eight of nine fitted";
  EXPECT_EQ(json.at("views")[0].at("pictures").at("photo"),
            "data:image/jpeg;base64," + Base64(std::string(1000, 'j')));
  EXPECT_EQ(json.at("views")[0].at("pictures").size(), 2U);
  std::map<std::string, int> charts;
  for (const Json& figure : json.at("figures").at("round")) {
    EXPECT_TRUE(json.at("history").at("rounds")[0].contains(figure.at("key"))) << figure;
    ++charts[figure.at("chart")];
  }
  EXPECT_EQ(charts.size(), 1U + 10U) << "figures without a chart, and ten charts";
  EXPECT_EQ(charts["Detail"], 1);
  EXPECT_EQ(charts["Cost"], 4);
  for (const Json& figure : json.at("figures").at("stage")) {
    EXPECT_TRUE(json.at("history").at("stages")[1].contains(figure.at("key"))) << figure;
  }
}

TEST(Report, IsSoundWithAlmostNothing) {
  ReportData data;
  data.status = "failed";
  ExpectSound(ReportJson(data, {}));
  data = SomeData(1, 0);
  data.history.stages.pop_back();
  data.history.rounds.resize(1);
  data.view_pictures.clear();
  optim::RoundReport& round = data.history.rounds.front();
  round.cost_total = round.psnr_linear_val = std::numeric_limits<double>::quiet_NaN();
  round.wall_s = std::numeric_limits<double>::infinity();
  const Json json = ReportJson(data, {});
  ExpectSound(json);
  EXPECT_TRUE(json.at("history").at("rounds")[0].at("cost_total").is_null());
  EXPECT_EQ(json.at("history").at("rounds")[0].at("wall_s"), "inf");
}

TEST(Report, NothingFromTheRunBecomesMarkup) {
  ReportData data = SomeData(2, 10);
  RunRecord& record = data.record;
  data.run_path = record.name = record.reason = record.host.name = record.host.cpu = kNasty;
  record.program_version = record.build = record.config_path = kNasty;
  record.started_utc = record.ended_utc = kNasty;
  record.libraries = {{kNasty, kNasty}};
  record.assumptions = record.warnings = record.attributions = {kNasty};
  record.inputs = {{kNasty, 1, kNasty}};
  record.sessions.push_back({{kNasty, "a b'c"}, 1, kNasty, kNasty, 3, kNasty});
  data.config = data.resolved_config = kNasty;
  ParameterSummary& parameter = data.history.parameters.emplace_back();
  parameter.name = parameter.unit = kNasty;
  for (StageEntry& entry : data.history.stages) {
    entry.report.stage = entry.report.kept = entry.report.stop_reason = kNasty;
    for (optim::ViewReport& view : entry.report.views) view.name = kNasty;
  }
  for (optim::RoundReport& round : data.history.rounds) round.stage = round.linear_solver = kNasty;
  const Json json = ReportJson(data, {});
  ExpectSound(json);
  const std::string html = ReportPage(json);
  EXPECT_EQ(Count(html, "<script>alert"), 0);
  EXPECT_EQ(Count(html, "<!--"), 0);
  EXPECT_EQ(html.find('\x01'), std::string::npos);
  EXPECT_EQ(html.find('\xff'), std::string::npos);
}

TEST(Report, StaysBelowItsSizeAndSaysSo) {
  const ReportData data = SomeData(60, 200000);
  const ReportOptions options;
  const Json json = ReportJson(data, options);
  const std::size_t size = ReportPage(json).size();
  EXPECT_LE(size, options.max_bytes);
  EXPECT_GT(size, options.max_bytes * 9 / 10);
  EXPECT_EQ(Count(json.at("views_note").get<std::string>(),
                  "views were left out to keep this file below 8.0 MB."),
            1);
  ExpectSound(json);
  EXPECT_EQ(Count(ReportPage(ReportJson(SomeData(12, 1000), {})), "were left out"), 0);
}

Json SomeModel(const std::string& positions, const std::string& triangles) {
  return {{"version", 1},
          {"meshes",
           Json::array({{{"name", kNasty.substr(0, 40)},
                         {"num_triangles", 12345},
                         {"positions", positions},
                         {"triangles", triangles}}})},
          {"cameras", Json::array()}};
}

TEST(Report, HasTheModelOfItsRun) {
  ReportData data = SomeData(2, 10);
  EXPECT_TRUE(ReportJson(data, {}).at("model").is_null());
  data.model = SomeModel("end", "both");
  data.start_model = SomeModel("begin", "both");
  Json json = ReportJson(data, {});
  ExpectSound(json);
  EXPECT_EQ(json["model"]["result"], data.model);
  EXPECT_EQ(json["model"]["start"]["meshes"][0]["positions"], "begin");
  EXPECT_TRUE(json["model"]["start"]["meshes"][0]["triangles"].is_null()) << "those of the result";
  EXPECT_EQ(json["model"]["note"], "");
  data.start_model = SomeModel("begin", "other");
  EXPECT_EQ(ReportJson(data, {})["model"]["start"]["meshes"][0]["triangles"], "other");
}

TEST(Report, TheServedPageAsksItsServerOnly) {
  const std::string html = LivePage(ReportJson(SomeData(2, 10), {}));
  EXPECT_EQ(HtmlFault(html), "");
  EXPECT_EQ(Count(html, "default-src 'none'; connect-src 'self'; img-src data:;"), 1);
  EXPECT_EQ(Count(html, CspHash(LiveJs())), 1);
  EXPECT_EQ(Count(html, ThreeJs()), 1) << "a model may come";
  EXPECT_EQ(Count(LiveJs(), "fetch("), 1);
}

TEST(Report, SaysWhichModelsAreTooLarge) {
  ReportData data = SomeData(4, 1000);
  data.model = SomeModel(std::string(2'000'000, 'a'), "both");
  data.start_model = SomeModel(std::string(2'000'000, 'b'), "both");
  Json json = ReportJson(data, {});
  EXPECT_FALSE(json["model"]["result"].is_null());
  EXPECT_TRUE(json["model"]["start"].is_null());
  std::string note = json["model"]["note"];
  EXPECT_EQ(Count(note, "The shape that the fit began with is not shown: its 12345 triangles"), 1);
  EXPECT_EQ(Count(note, "--max-size-mb 11`"), 1) << note;
  EXPECT_LE(ReportPage(json).size(), ReportOptions{}.max_bytes);
  EXPECT_TRUE(ReportJson(data, {.max_bytes = 11'000'000})["model"]["note"] == "") << "as it says";
  data.model = SomeModel(std::string(5'000'000, 'a'), "both");
  json = ReportJson(data, {});
  EXPECT_TRUE(json["model"]["result"].is_null() && json["model"]["start"].is_null());
  EXPECT_EQ(Count(json["model"]["note"].get<std::string>(), "The fitted shape is not shown"), 1);
  ExpectSound(json);
  EXPECT_LT(ReportPage(json).size(), 400'000U) << "no library for nothing";
}

TEST(Report, LongListsOfInputsAndLongConfigsAreCut) {
  ReportData data = SomeData(2, 10);
  data.record.inputs.assign(5000, {"photo.jpg", 3, std::string(64, 'a')});
  data.config = std::string(5'000'000, 'c');
  const Json json = ReportJson(data, {});
  EXPECT_EQ(json.at("run").at("inputs").size(), 300U);
  EXPECT_EQ(json.at("num_inputs"), 5000);
  EXPECT_EQ(Count(json.at("config").get<std::string>(), "The rest is in the file"), 1);
  EXPECT_LT(ReportPage(json).size(), 400'000U);
}

TEST(Report, LongConfigsAreCutBetweenCharacters) {
  ReportData data = SomeData(2, 10);
  for (int i = 0; i < 100'000; ++i) data.config += "…";
  EXPECT_EQ(Count(JsonText(ReportJson(data, {})), "\uFFFD"), 0);
}

TEST(Report, ShowsTheWorstViewsFirst) {
  ReportData data = SomeData(12, 10);
  std::vector<optim::ViewReport>& views = data.history.stages.back().report.views;
  views[7].psnr_srgb = 3.0;
  views[8].psnr_srgb = 4.0;
  const Json json = ReportJson(data, {});
  EXPECT_EQ(json.at("views")[0].at("index"), 8) << "the worst held-out view";
  EXPECT_EQ(json.at("views")[3].at("index"), 7) << "the worst fitted view";
}

TEST(Report, SaysHowTheRunEnded) {
  ReportData data = SomeData(2, 10);
  data.record.reason = "interrupted";
  for (const auto& [status, words] :
       {std::pair{"finished", "The fit finished: interrupted."},
        {"stopped", "It can be continued with: pathfit resume /runs/axe/x"},
        {"failed", "The fit failed: interrupted."},
        {"killed", "It can be continued with: pathfit resume /runs/axe/x"},
        {"running", "was running when this report was written"}}) {
    data.status = status;
    const std::string sentence = ReportJson(data, {}).at("sentence");
    EXPECT_EQ(Count(sentence, words), 1) << sentence;
  }
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
  EXPECT_EQ(DerivedWarnings(data.history)[1], "Ended at a bound: paint.roughness.");
  EXPECT_EQ(ReportJson(data, {}).at("warnings").size(), 3U);
  for (int i = 0; i < 9; ++i)
    data.history.parameters.push_back(ParameterSummary(data.history.parameters.front()));
  EXPECT_NE(DerivedWarnings(data.history)[1].find(" and 2 more."), std::string::npos);
  for (optim::ViewReport& view : last.views) view.validation = false;
  EXPECT_NE(DerivedWarnings(data.history).front().find("No view was held out"), std::string::npos);
}

}  // namespace
}  // namespace pathfit::app::report_test
