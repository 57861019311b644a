#include "app/output/fit_recorder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

#include "app/output/report.h"
#include "app/output/viewed_model.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/exr_file.h"
#include "tests/app/output/html_check.h"
#include "tests/app/output/synthetic_run.h"

namespace pathfit::app::fit_recorder_test {
namespace {

namespace fs = std::filesystem;

constexpr int kRoundsPerStage = 3;
constexpr int kLastStep = 9;
constexpr int kWidth = 40, kHeight = 30;

TerminalOptions Silent() {
  TerminalOptions options;
  options.progress = ProgressMode::kNone;
  options.write = [](std::string_view) {};
  options.columns = [] { return 80; };
  return options;
}

/// A fit's reports from after `step` on, with its stage ends, until `stop` rounds are done.
class SyntheticFit {
 public:
  SyntheticFit(const fs::path& root,
               int step,
               int resume_step = 0,
               const RecorderOptions& options = {})
      : run_(root), terminal_(Silent()), log_(terminal_, LogLevel::kInfo), progress_(terminal_) {
    if (step == 0) {
      RunRecord record = MakeRunRecord({"pathfit", "fit"});
      record.name = "axe";
      record_ = std::make_unique<RunRecordFile>(run_.Record(), record);
    } else {
      record_ = std::make_unique<RunRecordFile>(
          run_.Record(), std::vector<std::string>{"resume"}, resume_step);
    }
    recorder_ =
        std::make_unique<FitRecorder>(run_, set_, *record_, log_, progress_, options, resume_step);
  }

  void Stage(const std::string& name, int rounds, double wrong) {
    for (int i = 0; i < static_cast<int>(set_.views.size()); ++i) {
      recorder_->OnView(
          name,
          static_cast<std::size_t>(i),
          DiscFilm(kWidth / 2, kHeight / 2, i, wrong),
          optim::PackedLevel(set_.views[static_cast<std::size_t>(i)], set_, 0.5).Unpack());
    }
    recorder_->OnStage(MakeStage(name, rounds, wrong, set_));
  }
  void Rounds(int first, int last) {
    for (int step = first; step <= last; ++step) {
      const optim::RoundReport round = MakeRound(step, kRoundsPerStage);
      recorder_->OnRound(round);
      if (round.round == round.max_rounds) Stage(round.stage, kRoundsPerStage, 0.5 / step);
    }
  }
  FitRecorder& recorder() { return *recorder_; }
  Log& log() { return log_; }
  const RunDirectory& run() const { return run_; }
  const optim::ObservationSet& set() const { return set_; }

 private:
  optim::ObservationSet set_ = MakeObservations(5, kWidth, kHeight);
  RunDirectory run_;
  Terminal terminal_;
  Log log_;
  Progress progress_;
  std::unique_ptr<RunRecordFile> record_;
  std::unique_ptr<FitRecorder> recorder_;
};

TEST(FitRecorder, WritesTheRunDirectory) {
  const TemporaryFolder folder("recorder");
  SyntheticFit fit(folder.path(), 0);
  fit.Stage("start", 0, 1.0);
  fit.Rounds(1, kLastStep);
  fit.log().Warn("one mask is black");
  const renderer::Scene scene = MakeScene(fit.set());
  fit.recorder().RecordScenes(MakeSpec(),
                              scene,
                              scene,
                              {{"IMG_0001.jpg.exposure", {0.125}},
                               {"paint.roughness", {std::numeric_limits<double>::infinity()}}});
  fit.recorder().Finish(RunStatus::kFinished, "all stages done", 0);
  const FitHistory history = ReadHistory(fit.run().History());
  ASSERT_EQ(history.gain_errors.size(), 5U);
  EXPECT_EQ(history.gain_errors[1], 0.125);
  EXPECT_TRUE(std::isnan(history.gain_errors[2]));
  EXPECT_EQ(
      std::ranges::count(
          DerivedWarnings(history),
          "Not determined by the photos, or hidden by the renderings' noise: paint.roughness."),
      1);

  const fs::path held_out = fit.run().Images() / "IMG_0000";
  for (const char* file : {"start_fit.png",
                           "start_fit.exr",
                           "shape_difference.png",
                           "colours_difference.exr",
                           "thumbnail_photo.jpg",
                           "thumbnail_silhouette.jpg"}) {
    EXPECT_TRUE(fs::is_regular_file(held_out / file)) << file;
  }
  EXPECT_FALSE(fs::exists(fit.run().Images() / "IMG_0001/start_fit.exr"));
  EXPECT_EQ(renderer::ReadExr(held_out / "shape_fit.exr").width, kWidth / 2);

  const RunRecord record = ReadRunRecord(fit.run().Record());
  EXPECT_EQ(record.status, RunStatus::kFinished);
  EXPECT_EQ(record.stages.size(), 4U);
  EXPECT_EQ(record.warnings, std::vector<std::string>{"one mask is black"});

  const std::string html = renderer::ReadWholeFile(fit.run().Report());
  EXPECT_EQ(HtmlFault(html), "");
  EXPECT_EQ(Count(html, "data:image/jpeg;base64,"), 25);
  EXPECT_EQ(Count(html, "data:image/png;base64,"), 2);
  EXPECT_EQ(Count(html, "one mask is black"), 2) << "in run.json and in the verdict";
  const Json report = ReportJson(LoadReportData(fit.run()), {});
  EXPECT_EQ(report.at("views").size(), 5U);
  for (const Json& view : report.at("views")) EXPECT_EQ(view.at("pictures").size(), 5U);
}

TEST(FitRecorder, AReportThatCannotBeWrittenEndsNoFit) {
  const TemporaryFolder folder("recorder_page");
  SyntheticFit fit(folder.path(), 0);
  fs::create_directories(fit.run().Report() / "in the way");
  fit.Stage("start", 0, 1.0);
  fit.Rounds(1, kLastStep);
  fit.recorder().Finish(RunStatus::kFinished, "all stages done", 0);
  const RunRecord record = ReadRunRecord(fit.run().Record());
  EXPECT_EQ(record.status, RunStatus::kFinished);
  ASSERT_FALSE(record.warnings.empty());
  EXPECT_NE(record.warnings.front().find("no report is written: "), std::string::npos)
      << record.warnings.front();
}

TEST(FitRecorder, KeepsTheModelsOfTheStartAndOfTheNewestScene) {
  const TemporaryFolder folder("recorder_model");
  SyntheticFit fit(folder.path(), 0);
  renderer::Scene scene = MakeScene(fit.set());
  fit.recorder().OnScene("start", scene, {});
  EXPECT_EQ(ReadViewedModel(fit.run().Model()), ReadViewedModel(fit.run().StartModel()));
  scene.meshes[0].mesh.positions[0].x += 1.0;
  fit.recorder().OnScene("shape", scene, {});
  const Json box = ReadViewedModel(fit.run().StartModel()).at("meshes")[0].at("box");
  EXPECT_NE(ReadViewedModel(fit.run().Model()).at("meshes")[0].at("box"), box);
  const Json report = ReportJson(LoadReportData(fit.run()), {});
  EXPECT_EQ(report["model"]["start"]["meshes"][0]["box"], box);
  const TemporaryFolder other("recorder_no_model");
  SyntheticFit without(other.path(), 0, 0, {.report = false});
  without.recorder().OnScene("start", scene, {});
  EXPECT_FALSE(fs::exists(without.run().Model())) << "nothing that only a report needs";
}

TEST(FitRecorder, AKilledAndResumedRunLeavesTheFilesOfAStraightOne) {
  const TemporaryFolder straight("recorder_straight");
  {
    SyntheticFit fit(straight.path(), 0);
    fit.Stage("start", 0, 1.0);
    fit.Rounds(1, kLastStep);
    fit.recorder().Finish(RunStatus::kFinished, "", 0);
  }
  for (int killed_after = 1; killed_after < kLastStep; ++killed_after) {
    for (int checkpoint = std::max(0, killed_after - 2); checkpoint <= killed_after; ++checkpoint) {
      const TemporaryFolder folder("recorder_killed");
      {
        SyntheticFit fit(folder.path(), 0);
        fit.Stage("start", 0, 1.0);
        fit.Rounds(1, killed_after);
      }
      SyntheticFit fit(folder.path(), killed_after, checkpoint);
      fit.Rounds(checkpoint + 1, kLastStep);
      fit.recorder().Finish(RunStatus::kFinished, "", 0);
      for (const char* file :
           {"metrics.csv", "history.json", "images/IMG_0003/thumbnail_result.jpg"}) {
        ASSERT_EQ(renderer::ReadWholeFile(folder.path() / file),
                  renderer::ReadWholeFile(straight.path() / file))
            << file << " " << killed_after << " " << checkpoint;
      }
    }
  }
}

TEST(FitRecorder, TheReportIsMadeFromDiskAlone) {
  const TemporaryFolder folder("recorder_report");
  {
    SyntheticFit fit(folder.path(), 0);
    fit.Stage("start", 0, 1.0);
    fit.Rounds(1, 4);
    fit.recorder().Finish(RunStatus::kStopped, "interrupted", 130);
  }
  const RunDirectory run(folder.path());
  const std::string html = renderer::ReadWholeFile(run.Report());
  fs::remove(run.Report());
  WriteReport(run);
  EXPECT_EQ(renderer::ReadWholeFile(run.Report()), html);
  EXPECT_EQ(Count(html, "pathfit resume " + folder.path().string()), 1);
}

TEST(FitRecorder, WritesNoReportWhenNoneIsWanted) {
  const TemporaryFolder folder("recorder_no_report");
  SyntheticFit fit(folder.path(), 0, 0, {.report = false});
  fit.Stage("start", 0, 1.0);
  fit.Rounds(1, kLastStep);
  fit.recorder().Finish(RunStatus::kFinished, "", 0);
  EXPECT_FALSE(fs::exists(fit.run().Report()));
  EXPECT_TRUE(fs::exists(fit.run().History()));
}

TEST(FitRecorder, WritesLargePicturesOfOneStageWhenOnlyThoseAreWanted) {
  const TemporaryFolder folder("recorder_pictures");
  SyntheticFit fit(folder.path(), 0, 0, {.only_pictures_of = "colours"});
  fit.Stage("start", 0, 1.0);
  fit.Rounds(1, kLastStep);
  std::vector<std::string> names;
  for (const auto& file : fs::directory_iterator(fit.run().Images() / "IMG_0000")) {
    names.push_back(file.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names,
            (std::vector<std::string>{"colours_difference.exr",
                                      "colours_difference.png",
                                      "colours_fit.exr",
                                      "colours_fit.png",
                                      "thumbnail_difference.jpg",
                                      "thumbnail_photo.jpg",
                                      "thumbnail_result.jpg",
                                      "thumbnail_silhouette.jpg",
                                      "thumbnail_start.jpg"}));
}

TEST(FitRecorder, WarningsOfEarlierSessionsAreKept) {
  const TemporaryFolder folder("recorder_warnings");
  {
    SyntheticFit fit(folder.path(), 0);
    fit.log().Warn("first");
    fit.recorder().Finish(RunStatus::kStopped, "interrupted", 130);
  }
  SyntheticFit fit(folder.path(), 1, 0);
  fit.log().Warn("second");
  fit.log().Warn("first");
  fit.recorder().Finish(RunStatus::kFinished, "", 0);
  EXPECT_EQ(ReadRunRecord(fit.run().Record()).warnings,
            (std::vector<std::string>{"first", "second"}));
}

}  // namespace
}  // namespace pathfit::app::fit_recorder_test
