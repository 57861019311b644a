#pragma once

#include <utility>
#include <vector>

#include "optim/round/fit_report.h"
#include "optim/round/stage_plan.h"

namespace pathfit::app {

/// How long a fit will still take, all stages with what is rendered at their ends: by what its
/// rounds took so far, for rounds, samples and pixels as they usually are (optim::StagePlan). Of
/// surfaces, a level's second round tells more: where little of what is left is the renderings'
/// noise, the photos end levels soon.
class RemainingTime {
 public:
  void Expect(std::vector<optim::StagePlan> stages) { stages_ = std::move(stages); }
  void OnRound(const optim::RoundReport& report);
  void OnStage(const optim::StageReport& report);
  /// After the newest round. Without expected stages that of the round is the only one.
  [[nodiscard]] double Seconds() const;

 private:
  struct Round {
    double seconds = 0.0, work = 0.0;
  };
  /// Of a round's stage; that of the default if it was not expected.
  [[nodiscard]] optim::StagePlan PlanOf(const optim::RoundReport& report) const;
  /// Rounds of the plan's level number `level`, of the stage of the newest round.
  [[nodiscard]] int LikelyRounds(const optim::StagePlan& plan, std::size_t level) const;
  /// Of what the stage of the newest round still has to do.
  [[nodiscard]] double WorkOfStage() const;

  std::vector<optim::StagePlan> stages_;
  std::vector<Round> rounds_;  ///< of this stage
  optim::RoundReport newest_;
  int rounds_of_level_ = 0;
  optim::LevelNoise noise_;    ///< of the stage's newest level that has it; 0: none yet
  double last_wall_s_ = -1.0;  ///< of the newest report; negative before the first
  double end_s_ = 0.0;         ///< of what a stage's end took
  bool ended_ = true;          ///< no round since
};

}  // namespace pathfit::app
