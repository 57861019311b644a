#include "app/output/metrics_csv.h"

#include <algorithm>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "tests/app/output/synthetic_run.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;

std::string StraightRun(const fs::path& path, int rounds) {
  MetricsCsv csv(path, 0);
  for (int step = 1; step <= rounds; ++step) csv.Append(MakeRound(step, 4));
  return renderer::ReadWholeFile(path);
}

TEST(MetricsCsv, HasOneCellPerColumnInEveryRow) {
  const auto commas = [](const std::string& s) { return std::count(s.begin(), s.end(), ','); };
  EXPECT_EQ(commas(MetricsCsv::Header()), commas(MetricsCsv::Row(MakeRound(1, 4))));
  optim::RoundReport empty;
  empty.cost_total = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(commas(MetricsCsv::Header()), commas(MetricsCsv::Row(empty)));
  EXPECT_EQ(MetricsCsv::Row(empty).find("nan"), std::string::npos);
}

TEST(MetricsCsv, ResumedFileEqualsThatOfAStraightRun) {
  const TemporaryFolder folder("metrics");
  const std::string straight = StraightRun(folder.path() / "straight.csv", 9);
  for (int killed_after = 0; killed_after <= 9; ++killed_after) {
    for (int checkpoint = 0; checkpoint <= killed_after; ++checkpoint) {
      const fs::path path = folder.path() / "killed.csv";
      fs::remove(path);
      StraightRun(path, killed_after);
      std::ofstream(path, std::ios::app) << MetricsCsv::Row(MakeRound(10, 4)).substr(0, 30);
      MetricsCsv resumed(path, checkpoint);
      for (int step = checkpoint + 1; step <= 9; ++step) resumed.Append(MakeRound(step, 4));
      ASSERT_EQ(renderer::ReadWholeFile(path), straight) << killed_after << " " << checkpoint;
    }
  }
}

TEST(MetricsCsv, ARepeatedStepReplacesWhatFollows) {
  const TemporaryFolder folder("metrics_repeat");
  const fs::path path = folder.path() / "metrics.csv";
  StraightRun(path, 6);
  MetricsCsv csv(path, 6);
  csv.Append(MakeRound(3, 4));
  EXPECT_EQ(renderer::ReadWholeFile(path), StraightRun(folder.path() / "other.csv", 3));
}

TEST(MetricsCsv, RefusesAForeignFile) {
  const TemporaryFolder folder("metrics_foreign");
  renderer::WriteFileAtomically(folder.path() / "metrics.csv", "a,b\n1,2\n");
  EXPECT_THROW(MetricsCsv(folder.path() / "metrics.csv", 0), renderer::IoError);
  EXPECT_THROW(MetricsCsv(folder.path() / "none/metrics.csv", 0), renderer::IoError);
}

TEST(MetricsCsv, QuotesNamesAndKeepsOneLinePerRow) {
  optim::RoundReport report = MakeRound(1, 4);
  report.stage = "a,\"b\"\nc";
  const std::string row = MetricsCsv::Row(report);
  EXPECT_NE(row.find("\"a,\"\"b\"\" c\""), std::string::npos);
  EXPECT_EQ(row.find('\n'), std::string::npos);
  EXPECT_EQ(CsvNumber(0.1), "0.1");
  EXPECT_EQ(std::stod(CsvNumber(1.0 / 3.0)), 1.0 / 3.0);
}

}  // namespace
}  // namespace pathfit::app
