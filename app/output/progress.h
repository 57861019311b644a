#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "app/output/fit_history.h"
#include "app/output/remaining_time.h"
#include "app/output/terminal.h"
#include "optim/round/fit_report.h"

namespace pathfit::app {

/// Shows a fit on standard error, by the terminal's mode:
/// kBar: one status line, redrawn at most five times a second, never wider than the terminal;
/// kPlain and kJson: one line per round but at most one per 10 s, plus the first round and the end
/// of each stage; kNone: nothing. Numbers that are not finite are left out (null in JSON).
class Progress {
 public:
  using Clock = std::function<double()>;  ///< seconds, monotonic

  explicit Progress(Terminal& terminal);
  Progress(Terminal& terminal, Clock clock);

  /// The stages of the fit, so that the time it will still take is that of all.
  void Expect(std::vector<optim::StagePlan> stages) { remaining_.Expect(std::move(stages)); }
  void OnRound(const optim::RoundReport& report);
  void OnStage(const optim::StageReport& report);
  /// Removes the status line.
  void Finish();

 private:
  /// Mean seconds per round of this stage, over the last few rounds.
  double UpdateSecondsPerRound(const optim::RoundReport& report);

  Terminal& terminal_;
  Clock clock_;
  RemainingTime remaining_;
  std::string stage_;
  double last_output_s_ = 0.0;
  double last_wall_s_ = 0.0;
  double seconds_per_round_ = 0.0;
  bool any_round_ = false;
};

/// The status line within `columns`. Where there is little room, seconds per round are left out
/// first; then the bar is shortened, figures are left out, then the bar and what is on the right.
/// `eta_s`: of the whole fit (RemainingTime).
std::string StatusLine(const optim::RoundReport& report,
                       double seconds_per_round,
                       double eta_s,
                       int columns,
                       bool utf8,
                       bool color);
/// One line of plain progress, without a newline: time, level and key=value pairs.
std::string PlainLine(const optim::RoundReport& report,
                      double seconds_per_round,
                      double eta_s,
                      const std::string& time);
/// The same of a round or of a stage's end without time, level and what is to come, for logs.
std::string RoundWords(const optim::RoundReport& report);
std::string StageWords(const optim::StageReport& report);
/// What a fit came to: PSNR and IoU of its start and of its newest stage, of held-out photos if
/// there are any. Empty without two stages' ends, the start's counted.
std::string ResultWords(const FitHistory& history);
/// What makes one doubt a finished fit that explains hardly anything of its photos, or of held-out
/// ones far less than of others; empty for others.
std::string DoubtWords(const FitHistory& history);
/// One JSON object with every figure of the round, named as in metrics.csv.
std::string JsonLine(const optim::RoundReport& report,
                     double seconds_per_round,
                     double eta_s,
                     const std::string& time);

/// "3:49" or "1:02:05"; "?" when not finite. Negative durations count as zero.
std::string ClockText(double seconds);
/// For people: "12.3 s", "4 min 05 s", "2 h 07 min".
std::string DurationText(double seconds);

}  // namespace pathfit::app
