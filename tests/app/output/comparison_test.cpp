#include "app/output/comparison.h"

#include <limits>

#include <gtest/gtest.h>

#include "renderer/io/atomic_file.h"
#include "tests/app/output/html_check.h"
#include "tests/app/output/synthetic_run.h"

namespace pathfit::app::comparison_test {
namespace {

namespace fs = std::filesystem;

ComparedRun MakeRun(const std::string& label, double wrong, const std::string& config) {
  const optim::ObservationSet set = MakeObservations(9, 8, 6);
  ComparedRun run;
  run.label = label;
  run.data.run_path = "/runs/" + label;
  run.data.status = "finished";
  run.data.record.name = label;
  run.data.record.wall_s = 100.0;
  run.data.resolved_config = config;
  AddStage(MakeStage("start", 0, 1.0, set), run.data.history);
  for (int step = 1; step <= 6; ++step) AddRound(MakeRound(step, 4), run.data.history);
  AddStage(MakeStage("all", 6, wrong, set), run.data.history);
  run.data.view_pictures.assign(set.views.size(), {{"photo", "photo"}, {"result", label}});
  return run;
}

std::vector<ComparedRun> TwoRuns() {
  return {MakeRun("good", 0.1, "seed: 1\nstages:\n  - {name: all, spp: 8}\n"),
          MakeRun("bad", 0.5, "seed: 1\nstages:\n  - {name: all, spp: 16, free: [a, b]}\n")};
}

TEST(Comparison, TableHasALineForEachRunAndWhatDiffers) {
  std::vector<ComparedRun> runs = TwoRuns();
  optim::StageReport& last = runs[1].data.history.stages.back().report;
  last.iou_val = last.iou_fit = std::numeric_limits<double>::quiet_NaN();
  const std::string text = ComparisonTable(runs);
  EXPECT_EQ(Count(text, "\ngood "), 1) << text;
  EXPECT_EQ(Count(text, "\nbad "), 1) << text;
  EXPECT_EQ(Count(text, " - "), 3) << "two figures without a mask, and a setting that one has\n"
                                   << text;
  EXPECT_EQ(Count(text, "stages.all.spp"), 1) << text;
  EXPECT_EQ(Count(text, "[a, b]"), 1) << text;
  EXPECT_EQ(Count(text, "seed"), 0) << "is the same";
  runs[1].data.resolved_config = runs[0].data.resolved_config;
  EXPECT_EQ(Count(ComparisonTable(runs), "All settings are the same."), 1);
}

TEST(Comparison, FiguresAreThoseOfTheLastStage) {
  const std::vector<ComparedRun> runs = TwoRuns();
  const Json json = ComparisonFigures(runs);
  ASSERT_EQ(json.at("runs").size(), 2U);
  EXPECT_EQ(json.at("runs")[0].at("psnr_srgb_val_db"),
            runs[0].data.history.stages.back().report.psnr_srgb_val);
  EXPECT_EQ(json.at("runs")[0].at("rounds"), 6.0);
  EXPECT_EQ(json.at("runs")[0].at("wall_s"), 100.0);
  EXPECT_EQ(json.at("differences").size(), 2U);
}

TEST(Comparison, PhotosOfOneNameMayBeDifferent) {
  std::vector<ComparedRun> runs = TwoRuns();
  runs[1].data.view_pictures[3]["photo"] = "another";
  int others = 0;
  const Json json = ComparisonJson(runs, {});
  for (const Json& view : json.at("views")) {
    EXPECT_TRUE(view.at("results")[0].at("photo").is_null());
    others += view.at("results")[1].at("photo").is_string() ? 1 : 0;
  }
  EXPECT_EQ(others, 1);
}

TEST(Comparison, PageShowsPicturesSideBySideHeldOutOnesFirst) {
  std::vector<ComparedRun> runs = TwoRuns();
  // A run with fewer views, whose pictures are missing.
  runs[1].data.history.stages.back().report.views.resize(2);
  runs[1].data.view_pictures.clear();
  const Json json = ComparisonJson(runs, {});
  ASSERT_EQ(json.at("views").size(), 9U);
  EXPECT_EQ(json.at("views")[0].at("validation"), true);
  EXPECT_EQ(json.at("views").back().at("validation"), false);
  for (const Json& view : json.at("views")) {
    EXPECT_TRUE(view.at("photo").is_string());
    ASSERT_EQ(view.at("results").size(), 2U);
    EXPECT_TRUE(view.at("results")[0].at("picture").is_string());
    EXPECT_TRUE(view.at("results")[1].at("picture").is_null());
  }
  EXPECT_EQ(json.at("runs")[0].at("history").size(), 6U);
  const std::string page = ReportPage(json);
  EXPECT_EQ(HtmlFault(page), "");
  EXPECT_EQ(Count(page, "<script"), 2);

  ReportOptions small;
  small.max_bytes = page.size() - 100;
  const Json cut = ComparisonJson(runs, small);
  EXPECT_LT(cut.at("views").size(), 9U);
  EXPECT_LE(ReportPage(cut).size(), small.max_bytes);
}

TEST(Comparison, IsSoundOfRunsThatHardlyBegan) {
  const std::vector<ComparedRun> runs(2);
  EXPECT_EQ(HtmlFault(ReportPage(ComparisonJson(runs, {}))), "");
  EXPECT_EQ(Count(ComparisonTable(runs), "PSNR"), 2);
}

TEST(Comparison, LabelsTellRunsApart) {
  const fs::path top =
      fs::temp_directory_path() / ("pathfit_comparison_" + std::to_string(getpid()));
  std::vector<RunDirectory> directories;
  for (const char* path : {"a/one", "a/two", "b/two"}) {
    fs::create_directories(top / path);
    RunRecord record = MakeRunRecord({"pathfit", "fit", "same.yaml"});
    record.name = "same";
    WriteRunRecord(top / path / "run.json", record);
    directories.emplace_back(top / path);
  }
  EXPECT_EQ(LoadRuns({directories[0], directories[1]})[1].label, "two");
  EXPECT_EQ(LoadRuns({directories[1], directories[2]})[0].label, (top / "a/two").string());
  EXPECT_EQ(LoadRuns({directories[1], directories[1]})[1].label, (top / "a/two").string() + " #2");
  fs::remove_all(top);
}

}  // namespace
}  // namespace pathfit::app::comparison_test
