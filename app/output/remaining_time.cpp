#include "app/output/remaining_time.h"

#include <algorithm>
#include <cmath>

namespace pathfit::app {
namespace {

// Found on the records of six fits of 8 to 66 photos, of 96 to 215 pixels.
constexpr double kSampleFloor = 8.0;     // what a pixel costs beside its samples, in samples
constexpr double kFewSampleFloor = 2.0;  // with few unknowns
constexpr double kScaleExponent = 1.9;   // small photos cost a little more than their pixels
constexpr int kLastRounds = 2;           // of a level that takes longer than usual
constexpr std::size_t kRememberedRounds = 3;
constexpr double kSameScale = 1e-3;

double WorkOf(const optim::StagePlan& plan, double samples, double scale) {
  const double floor = plan.kind.few ? kFewSampleFloor : kSampleFloor;
  return (samples + floor) * std::pow(scale, kScaleExponent);
}

double WorkOfLevel(const optim::StagePlan& plan, const optim::LevelPlan& level, int rounds) {
  double work = 0.0;
  for (int round = 0; round < rounds; ++round) {
    work += WorkOf(plan, optim::LikelySamples(plan, level, round), level.scale);
  }
  return work;
}

}  // namespace

void RemainingTime::OnRound(const optim::RoundReport& report) {
  const bool is_new_stage = ended_ || report.stage != newest_.stage;
  if (is_new_stage) rounds_.clear();
  if (is_new_stage || report.image_scale != newest_.image_scale) rounds_of_level_ = 0;
  ++rounds_of_level_;
  if (is_new_stage) noise_ = {};
  if (rounds_of_level_ == 2) {
    noise_ = {report.noise_relative, report.image_scale};
  }
  const double seconds = last_wall_s_ < 0.0 ? report.render_s + report.jacobian_s + report.linear_s
                                            : report.wall_s - last_wall_s_;
  if (std::isfinite(seconds) && seconds >= 0.0) {
    rounds_.push_back({seconds, WorkOf(PlanOf(report), report.samples.spp, report.image_scale)});
  }
  last_wall_s_ = report.wall_s;
  newest_ = report;
  ended_ = false;
}

void RemainingTime::OnStage(const optim::StageReport& report) {
  end_s_ = std::max(0.0, report.wall_s - std::max(0.0, last_wall_s_));
  last_wall_s_ = report.wall_s;
  ended_ = true;
}

optim::StagePlan RemainingTime::PlanOf(const optim::RoundReport& report) const {
  const auto index = static_cast<std::size_t>(std::max(0, report.stage_index));
  return index < stages_.size() ? stages_[index] : optim::StagePlan();
}

int RemainingTime::LikelyRounds(const optim::StagePlan& plan, std::size_t level) const {
  return noise_.noise > 0.0 ? optim::LikelyRounds(plan, level, noise_)
                            : plan.levels[level].likely_rounds;
}

double RemainingTime::WorkOfStage() const {
  optim::StagePlan plan = PlanOf(newest_);
  plan.stage.max_rounds = newest_.max_rounds;
  const auto at_scale = [&](const optim::LevelPlan& level) {
    return std::abs(level.scale - newest_.image_scale) <= kSameScale * newest_.image_scale;
  };
  auto level = std::ranges::find_if(plan.levels, at_scale);
  if (level == plan.levels.end()) {
    optim::StageSpec stage = plan.stage;
    stage.image_scale = newest_.image_scale;
    stage.coarse_to_fine = false;
    plan = optim::PlanStage(stage, {.moves = true}, 1, 1.0);
    level = plan.levels.begin();
  }
  const bool is_last = level + 1 == plan.levels.end();
  const auto number = [&] { return static_cast<std::size_t>(level - plan.levels.begin()); };
  int left = LikelyRounds(plan, number()) - rounds_of_level_;
  if (left <= 0) left = is_last ? kLastRounds : 0;
  left = std::min(left, newest_.max_rounds - newest_.round);
  double samples = newest_.samples.spp;
  const double most = std::max(samples, level->factor * plan.stage.max_spp);
  const bool grows = samples > optim::LikelySamples(plan, *level, 0);
  const bool grew = grows || !plan.kind.moves;
  const int as_many = grew ? 0 : optim::RoundsBeforeGrowth(plan, *level) + 1 - rounds_of_level_;
  double work = 0.0;
  for (int i = 0; i < left; ++i) {
    if (i >= as_many) {
      samples = std::min(most, std::max(1.0, plan.stage.spp_growth) * samples);
    }
    work += WorkOf(plan, samples, level->scale);
  }
  for (++level; level != plan.levels.end(); ++level) {
    work += WorkOfLevel(plan, *level, LikelyRounds(plan, number()));
  }
  return work;
}

double RemainingTime::Seconds() const {
  double seconds = 0.0, work = 0.0;
  // A stage's first round sets up what the others find.
  const std::size_t known =
      rounds_.size() > 1 ? std::min(rounds_.size() - 1, kRememberedRounds) : rounds_.size();
  for (std::size_t i = rounds_.size() - known; i < rounds_.size(); ++i) {
    seconds += rounds_[i].seconds;
    work += rounds_[i].work;
  }
  if (!(work > 0.0)) return 0.0;
  double ahead = WorkOfStage();
  double ends = end_s_;
  const auto index = static_cast<std::size_t>(std::max(0, newest_.stage_index));
  for (std::size_t i = index + 1; i < stages_.size(); ++i) {
    for (const optim::LevelPlan& level : stages_[i].levels) {
      ahead += WorkOfLevel(stages_[i], level, level.likely_rounds);
    }
    ends += end_s_;
  }
  return ahead * seconds / work + ends;
}

}  // namespace pathfit::app
