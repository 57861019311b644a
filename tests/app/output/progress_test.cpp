#include "app/output/progress.h"

#include <limits>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/output/figures.h"
#include "app/output/log.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "tests/app/output/html_check.h"
#include "tests/app/output/synthetic_run.h"

namespace pathfit::app::progress_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TerminalOptions Options(ProgressMode progress, LineStyle style, std::string& out) {
  TerminalOptions options;
  options.progress = progress;
  options.style = style;
  options.utf8 = true;
  options.write = [&out](std::string_view text) { out += text; };
  options.columns = [] { return 100; };
  return options;
}

Environment Variables(std::map<std::string, std::string> values) {
  return [values = std::move(values)](const std::string& name) {
    const auto found = values.find(name);
    return found == values.end() ? std::string() : found->second;
  };
}

int Columns(const std::string& line) {
  return static_cast<int>(std::count_if(line.begin(), line.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U;
  }));
}

optim::RoundReport DocumentedRound() {
  optim::RoundReport r;
  r.stage = "shape";
  r.stage_index = 1;
  r.num_stages = 4;
  r.round = 31;
  r.max_rounds = 60;
  r.cost_total = 3.214e-3;
  r.cost_change_rel = -0.018;
  r.psnr_linear_val = 27.9;
  r.accepted = true;
  return r;
}

TEST(StatusLine, LooksAsDocumented) {
  EXPECT_EQ(
      StatusLine(DocumentedRound(), 7.9, 229.1, 110, true, false),
      "[2/4 shape] ██████████░░░░░░░░░░ 31/60  cost 3.214e-03 (-1.8 %)  held out 27.9 dB linear  "
      "7.9 s/it  ETA 3:49");
  EXPECT_EQ(StatusLine(DocumentedRound(), 7.9, 229.1, 110, false, false).substr(0, 40),
            "[2/4 shape] ##########---------- 31/60  ");
}

TEST(StatusLine, NeverWraps) {
  for (int columns = 1; columns < 120; ++columns) {
    EXPECT_LT(Columns(StatusLine(DocumentedRound(), 7.9, 229.1, columns, true, false)), columns);
  }
  EXPECT_EQ(StatusLine(DocumentedRound(), 7.9, 229.1, 80, true, false),
            "[2/4 shape] ████░░░░ 31/60  cost 3.214e-03  held out 27.9 dB linear  ETA 3:49");
  EXPECT_EQ(StatusLine(DocumentedRound(), 7.9, 229.1, 64, true, false),
            "[2/4 shape] ████░░░░ 31/60  held out 27.9 dB linear  ETA 3:49");
  EXPECT_EQ(Count(StatusLine(DocumentedRound(), 7.9, 229.1, 30, true, false), "█"), 0);
}

TEST(ResultWords, SayWhatAFitCameTo) {
  FitHistory history;
  optim::StageReport report;
  report.psnr_srgb_fit = 14.0;
  report.psnr_srgb_val = 18.13;
  report.iou_fit = report.iou_val = 0.9803;
  AddStage(report, history);
  EXPECT_EQ(ResultWords(history), "");
  report.stage = "all";
  report.psnr_srgb_fit = 30.0;
  report.psnr_srgb_val = 28.21;
  report.iou_val = 0.98929;
  AddStage(report, history);
  EXPECT_EQ(ResultWords(history),
            "PSNR of held-out photos 18.1 -> 28.2 dB (sRGB), mask IoU 0.980 -> 0.989");
  EXPECT_EQ(DoubtWords(history), "");
  history.stages.back().report.iou_val = 0.85;
  EXPECT_NE(DoubtWords(history).find("(28.2 dB, IoU 0.85) than fitted ones (30.0 dB, IoU 0.98)"),
            std::string::npos);
  history.stages.back().report.iou_val = 0.98;
  history.stages.back().report.psnr_srgb_val = 23.0;
  EXPECT_NE(DoubtWords(history).find("explained far worse"), std::string::npos);
  for (StageEntry& entry : history.stages) {
    entry.report.psnr_srgb_val = entry.report.iou_val = entry.report.iou_fit = kNan;
  }
  EXPECT_EQ(ResultWords(history), "PSNR of the photos 14.0 -> 30.0 dB (sRGB)");
  EXPECT_EQ(DoubtWords(history), "");
  history.stages.back().report.psnr_srgb_fit = 16.34;
  EXPECT_NE(DoubtWords(history).find("of the photos (16.3 dB)"), std::string::npos);
  history.stages.back().report.psnr_srgb_val = 15.0;
  EXPECT_NE(DoubtWords(history).find("of the held-out photos (15.0 dB)"), std::string::npos);
}

TEST(StatusLine, LeavesOutWhatIsNotANumber) {
  optim::RoundReport r = DocumentedRound();
  r.cost_total = r.cost_change_rel = r.psnr_linear_val = kNan;
  r.max_rounds = 0;
  EXPECT_EQ(StatusLine(r, 1.0, 10.0, 100, false, false).find("nan"), std::string::npos);
  EXPECT_EQ(StatusLine(r, 1.0, 10.0, 100, false, false).find("val"), std::string::npos);
}

TEST(PlainLine, LooksAsDocumented) {
  EXPECT_EQ(PlainLine(DocumentedRound(), 7.9, 229.1, "2026-11-21T03:47:12Z"),
            "2026-11-21T03:47:12Z info stage=shape it=31/60 cost=3.214e-03 dcost=-1.8% "
            "val_psnr_linear=27.9 s_per_it=7.9 eta_s=229");
}

TEST(JsonLine, IsOneJsonObject) {
  optim::RoundReport r = DocumentedRound();
  r.psnr_linear_val = kNan;
  const std::string line = JsonLine(r, 7.9, 229.1, "2026-11-21T03:47:12Z");
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const auto json = nlohmann::json::parse(line);
  EXPECT_EQ(json.at("stage"), "shape");
  EXPECT_EQ(json.at("round"), 31);
  EXPECT_EQ(json.at("cost_change_rel"), -0.018);
  EXPECT_TRUE(json.at("psnr_linear_val_db").is_null());
  Fields<optim::RoundReport>::Visit(r, [&json](const Figure& figure, const auto&) {
    EXPECT_TRUE(json.contains(figure.key)) << figure.key;
  });
}

TEST(Progress, PlainLinesAreThrottledButStageChangesAreNot) {
  std::string out;
  Terminal terminal(Options(ProgressMode::kPlain, LineStyle::kStamped, out));
  double now = 100.0;
  Progress progress(terminal, [&now] { return now; });
  for (int step = 1; step <= 30; ++step, now += 1.0) progress.OnRound(MakeRound(step, 30));
  EXPECT_EQ(Count(out, "\n"), 3);  // seconds 0, 10 and 20
  EXPECT_EQ(Count(out, "\r"), 0);
  EXPECT_EQ(Count(out, "\x1b"), 0);
  progress.OnStage(MakeStage("light", 30, 0.5, MakeObservations(2, 8, 6)));
  progress.OnRound(MakeRound(31, 30));
  EXPECT_EQ(Count(out, "\n"), 5);
  EXPECT_EQ(Count(out, "stage=light end=true"), 1);
  EXPECT_EQ(Count(out, "stage=shape it=1/30"), 1);
}

TEST(Progress, TheBarIsRedrawnFiveTimesASecondAtMost) {
  std::string out;
  Terminal terminal(Options(ProgressMode::kBar, LineStyle::kHuman, out));
  double now = 0.0;
  Progress progress(terminal, [&now] { return now; });
  for (int step = 1; step <= 100; ++step, now += 0.01) progress.OnRound(MakeRound(step, 200));
  EXPECT_EQ(Count(out, "\r\x1b[K"), 5);
  EXPECT_EQ(Count(out, "\n"), 0);
  progress.Finish();
  EXPECT_TRUE(out.ends_with("\r\x1b[K"));
}

TEST(Progress, TheEndOfAStageIsALineInEveryStyle) {
  optim::StageReport stage = MakeStage("light", 30, 0.5, MakeObservations(2, 8, 6));
  stage.wall_s = 245.0;
  stage.iou_val = kNan;
  const auto line = [&stage](ProgressMode mode, LineStyle style) {
    std::string out;
    Terminal terminal(Options(mode, style, out));
    Progress(terminal).OnStage(stage);
    return out;
  };
  const std::string sentence = line(ProgressMode::kBar, LineStyle::kHuman);
  EXPECT_TRUE(sentence.starts_with("light: 30 rounds, PSNR ")) << sentence;
  EXPECT_TRUE(sentence.ends_with(" (all rounds were used), after 4 min 05 s\n")) << sentence;
  EXPECT_EQ(Count(sentence, "nan"), 0);
  const auto json = nlohmann::json::parse(line(ProgressMode::kJson, LineStyle::kJson));
  EXPECT_EQ(json.at("end"), true);
  EXPECT_EQ(json.at("psnr_srgb_fit_db"), stage.psnr_srgb_fit);
  EXPECT_TRUE(json.at("iou_val").is_null());
}

TEST(Progress, NoneIsSilent) {
  std::string out;
  Terminal terminal(Options(ProgressMode::kNone, LineStyle::kHuman, out));
  Progress progress(terminal);
  progress.OnRound(MakeRound(1, 3));
  progress.OnStage(MakeStage("light", 3, 0.5, MakeObservations(2, 8, 6)));
  progress.Finish();
  EXPECT_EQ(out, "");
}

TEST(Log, LinesScrollAboveTheStatusLine) {
  std::string out;
  Terminal terminal(Options(ProgressMode::kBar, LineStyle::kHuman, out));
  Log log(terminal, LogLevel::kInfo);
  terminal.SetStatus("STATUS");
  out.clear();
  log.Info("hello");
  EXPECT_EQ(out, "\r\x1b[Khello\nSTATUS");
  terminal.ClearStatus();
  out.clear();
  log.Info("bye");
  EXPECT_EQ(out, "bye\n");
}

TEST(Log, HasLevelsStylesAndAFile) {
  const TemporaryFolder folder("log");
  std::string out;
  Terminal terminal(Options(ProgressMode::kPlain, LineStyle::kStamped, out));
  Log log(terminal, LogLevel::kWarn);
  log.AddFile(folder.path() / "log.txt");
  log.Write(LogLevel::kDebug, "detail");
  log.Info("quiet");
  log.Warn("careful \x1b[31m");
  log.Warn("careful \x1b[31m");
  EXPECT_EQ(Count(out, "\n"), 2);
  EXPECT_EQ(Count(out, "Z warning careful ?[31m\n"), 2);
  EXPECT_EQ(log.Warnings(), std::vector<std::string>{"careful ?[31m"});
  const std::string text = renderer::ReadWholeFile(folder.path() / "log.txt");
  EXPECT_EQ(Count(text, "\n"), 4);
  EXPECT_EQ(text[10], 'T');
  EXPECT_EQ(text[23], 'Z');
  EXPECT_EQ(Count(text, " debug detail\n"), 1);
  EXPECT_THROW(log.AddFile(folder.path() / "log.txt/x"), renderer::IoError);
}

TEST(Log, JsonLinesAreJson) {
  std::string out;
  Terminal terminal(Options(ProgressMode::kJson, LineStyle::kJson, out));
  Log log(terminal, LogLevel::kInfo);
  log.Error("a \"b\" \xff");
  EXPECT_EQ(nlohmann::json::parse(out).at("level"), "error");
}

TEST(Terminal, ColourRulesHaveTheirOrder) {
  EXPECT_TRUE(ResolveColor(ColorMode::kAlways, false, Variables({{"NO_COLOR", "1"}})));
  EXPECT_FALSE(ResolveColor(ColorMode::kNever, true, Variables({{"CLICOLOR_FORCE", "1"}})));
  EXPECT_FALSE(ResolveColor(
      ColorMode::kAuto, true, Variables({{"NO_COLOR", "1"}, {"CLICOLOR_FORCE", "1"}})));
  EXPECT_TRUE(ResolveColor(
      ColorMode::kAuto, false, Variables({{"CLICOLOR_FORCE", "1"}, {"TERM", "dumb"}})));
  EXPECT_FALSE(ResolveColor(ColorMode::kAuto, false, Variables({{"CLICOLOR_FORCE", "0"}})));
  EXPECT_FALSE(ResolveColor(ColorMode::kAuto, true, Variables({{"TERM", "dumb"}})));
  EXPECT_TRUE(ResolveColor(ColorMode::kAuto, true, Variables({})));
  EXPECT_FALSE(ResolveColor(ColorMode::kAuto, false, Variables({})));
}

TEST(Terminal, ABarNeedsATerminal) {
  EXPECT_EQ(ResolveProgress(ProgressMode::kAuto, true, Variables({})), ProgressMode::kBar);
  EXPECT_EQ(ResolveProgress(ProgressMode::kAuto, false, Variables({})), ProgressMode::kPlain);
  EXPECT_EQ(ResolveProgress(ProgressMode::kBar, false, Variables({})), ProgressMode::kPlain);
  EXPECT_EQ(ResolveProgress(ProgressMode::kAuto, true, Variables({{"TERM", "dumb"}})),
            ProgressMode::kPlain);
  EXPECT_EQ(ResolveProgress(ProgressMode::kJson, true, Variables({})), ProgressMode::kJson);
}

TEST(Progress, DurationsAreForPeople) {
  EXPECT_EQ(ClockText(229.1), "3:49");
  EXPECT_EQ(ClockText(3725.0), "1:02:05");
  EXPECT_EQ(ClockText(-1.0), "0:00");
  EXPECT_EQ(ClockText(kNan), "?");
  EXPECT_EQ(DurationText(12.34), "12.3 s");
  EXPECT_EQ(DurationText(245.0), "4 min 05 s");
  EXPECT_EQ(DurationText(7620.0), "2 h 07 min");
}

}  // namespace
}  // namespace pathfit::app::progress_test
