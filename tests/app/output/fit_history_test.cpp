#include "app/output/fit_history.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "tests/app/output/synthetic_run.h"

namespace pathfit::app::fit_history_test {
namespace {

TEST(FitHistory, ReadsBackWhatWasWritten) {
  const TemporaryFolder folder("history");
  const optim::ObservationSet set = MakeObservations(3, 8, 6);
  FitHistory history;
  AddStage(MakeStage("start", 0, 1.0, set), history);
  for (int step = 1; step <= 5; ++step) AddRound(MakeRound(step, 3), history);
  history.rounds.back().psnr_linear_val = std::numeric_limits<double>::quiet_NaN();
  AddStage(MakeStage("light", 3, 0.5, set), history);
  ParameterSummary parameter;
  parameter.name = "a \"b\" \xff";
  parameter.lower_bound = -std::numeric_limits<double>::infinity();
  parameter.upper_bound = 2.0 / 3.0;
  history.parameters.push_back(parameter);
  WriteHistory(folder.path() / "history.json", history);

  const FitHistory read = ReadHistory(folder.path() / "history.json");
  ASSERT_EQ(read.rounds.size(), 5U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(ToJson(read.rounds[i]), ToJson(history.rounds[i]));
  }
  EXPECT_TRUE(std::isnan(read.rounds.back().psnr_linear_val));
  ASSERT_EQ(read.stages.size(), 2U);
  EXPECT_EQ(read.stages[1].after_step, 5);
  EXPECT_EQ(read.stages[1].report.views[2].psnr_srgb, history.stages[1].report.views[2].psnr_srgb);
  ASSERT_EQ(read.parameters.size(), 1U);
  EXPECT_EQ(read.parameters[0].upper_bound, 2.0 / 3.0);
  EXPECT_EQ(read.parameters[0].lower_bound, -std::numeric_limits<double>::infinity());
}

TEST(FitHistory, TruncationForgetsLaterRoundsAndStages) {
  const optim::ObservationSet set = MakeObservations(2, 8, 6);
  FitHistory history;
  AddStage(MakeStage("start", 0, 1.0, set), history);
  for (int step = 1; step <= 3; ++step) AddRound(MakeRound(step, 3), history);
  AddStage(MakeStage("light", 3, 0.5, set), history);
  AddRound(MakeRound(4, 3), history);
  TruncateHistory(3, history);
  EXPECT_EQ(history.rounds.size(), 3U);
  EXPECT_EQ(history.stages.size(), 2U);
  TruncateHistory(2, history);
  EXPECT_EQ(history.rounds.size(), 2U);
  EXPECT_EQ(history.stages.size(), 1U);
}

TEST(FitHistory, AStageOrRoundThatComesAgainReplacesTheOld) {
  const optim::ObservationSet set = MakeObservations(2, 8, 6);
  FitHistory history;
  AddStage(MakeStage("start", 0, 1.0, set), history);
  AddStage(MakeStage("start", 0, 0.9, set), history);
  EXPECT_EQ(history.stages.size(), 1U);
  for (int step = 1; step <= 4; ++step) AddRound(MakeRound(step, 3), history);
  AddRound(MakeRound(2, 3), history);
  ASSERT_EQ(history.rounds.size(), 2U);
  EXPECT_EQ(history.rounds.back().step, 2);
}

TEST(FitHistory, AFigureThatTheFileLacksKeepsItsDefault) {
  const TemporaryFolder folder("history_few");
  renderer::WriteFileAtomically(folder.path() / "history.json", R"({"version": 2,
      "environment_exposure": 0.5,
      "rounds": [{"step": 3, "stage": "light", "cost_total": 0.25}],
      "stages": [{"after_step": 3, "stage": "light", "rounds": 3, "views": []}],
      "parameters": []})");
  const FitHistory read = ReadHistory(folder.path() / "history.json");
  ASSERT_EQ(read.rounds.size(), 1U);
  EXPECT_EQ(read.rounds[0].step, 3);
  EXPECT_EQ(read.rounds[0].cost_total, 0.25);
  EXPECT_EQ(read.rounds[0].jacobian_mb, 0.0) << "a figure that the file lacks";
  ASSERT_EQ(read.stages.size(), 1U);
  EXPECT_EQ(read.stages[0].report.rounds, 3);
}

TEST(MetricsCsv, HasOneCellPerColumnInEveryRow) {
  optim::RoundReport odd = MakeRound(1, 4);
  odd.cost_total = std::numeric_limits<double>::quiet_NaN();
  odd.stage = "a,\"b\"\nc";
  const std::string csv = CsvTable<optim::RoundReport>({MakeRound(1, 4), odd, {}});
  EXPECT_EQ(csv.find("nan"), std::string::npos);
  EXPECT_NE(csv.find("\"a,\"\"b\"\" c\""), std::string::npos);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_TRUE(csv.starts_with("step,stage,stage_index,"));
  const auto commas = [&csv](std::size_t from) {
    return std::count(csv.begin() + static_cast<std::ptrdiff_t>(from),
                      csv.begin() + static_cast<std::ptrdiff_t>(csv.find('\n', from)),
                      ',');
  };
  EXPECT_EQ(commas(0), commas(csv.find('\n') + 1));
  EXPECT_EQ(CsvTable<optim::RoundReport>({}), csv.substr(0, csv.find('\n') + 1));
  EXPECT_EQ(CsvCell(0.1), "0.1");
  EXPECT_EQ(CsvCell(1e-4), "0.0001");
  EXPECT_EQ(CsvCell(true), "1");
  EXPECT_EQ(std::stod(CsvCell(1.0 / 3.0)), 1.0 / 3.0);
}

TEST(FitHistory, RefusesDamagedFiles) {
  const TemporaryFolder folder("history_bad");
  for (const char* text : {"",
                           "[]",
                           "{\"version\": 1, \"rounds\": [], \"stages\": [], \"parameters\": []}",
                           "{\"version\": 9}",
                           "{\"version\":2,\"rounds\":3}",
                           "{\"version\": 2}"}) {
    renderer::WriteFileAtomically(folder.path() / "history.json", text);
    EXPECT_THROW(ReadHistory(folder.path() / "history.json"), renderer::IoError) << text;
  }
  EXPECT_THROW(ReadHistory(folder.path() / "none.json"), renderer::IoError);
}

}  // namespace
}  // namespace pathfit::app::fit_history_test
