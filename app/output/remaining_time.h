#pragma once

#include <string>
#include <vector>

#include "optim/round/fit_report.h"
#include "optim/round/fit_spec.h"

namespace pathfit::app {

/// How long a fit will still take, all stages with what is rendered at their ends: by what its
/// rounds took so far, for samples and pixels that grow as they usually do. When a stage ends by
/// itself cannot be known: one with a small max_rounds is taken to use all of them, another the
/// number that is usual.
class RemainingTime {
 public:
  void Expect(const optim::FitSpec& spec) { stages_ = spec.stages; }
  void OnRound(const optim::RoundReport& report);
  void OnStage(const optim::StageReport& report);
  /// After the newest round. Without expected stages that of the round is the only one.
  [[nodiscard]] double Seconds() const;

 private:
  struct Round {
    double seconds = 0.0, work = 0.0;
  };
  /// Where a stage is, and how it goes on.
  struct Course {
    double scale = 1.0, last_scale = 1.0, samples = 0.0;
    int rounds_of_level = 0, levels = 1, rounds = 0, max_rounds = 0;
    double first_samples = 0.0, most_samples = 0.0, growth = 1.0;
  };
  [[nodiscard]] Course CourseOf(const optim::StageSpec& spec) const;
  [[nodiscard]] double WorkAhead(Course course) const;

  std::vector<optim::StageSpec> stages_;
  std::vector<Round> rounds_;  ///< of this stage
  optim::RoundReport newest_;
  int rounds_of_level_ = 0, levels_ = 0;
  double last_wall_s_ = -1.0;  ///< of the newest report; negative before the first
  double end_s_ = 0.0;         ///< of what a stage's end took
  bool ended_ = true;          ///< no round since
};

}  // namespace pathfit::app
