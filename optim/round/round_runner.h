#pragma once

#include "optim/checkpoint/fit_state.h"
#include "optim/prior/prior_terms.h"
#include "optim/problem/fit_views.h"
#include "optim/problem/image_source.h"
#include "optim/ranks/division.h"
#include "optim/round/exposure_gauge.h"
#include "optim/round/fit_report.h"
#include "optim/round/fit_spec.h"

namespace pathfit::optim {

/// What stays the same through the rounds of a level.
struct StageContext {
  const FitSpec& spec;
  int stage = 0;
  const FitViews& views;
  const ParameterSet& set;
  const ExposureModel& exposure;
  const renderer::Scene& start;  ///< of the run
  const std::vector<PriorTerm>& priors;
  FreeGains free_gains = FreeGains::kNone;  ///< of held-out views
  double image_scale = 1.0;                 ///< of the level
  double sample_factor = 1.0;               ///< of the level (SampleFactor)
  Division& division;                       ///< of views
};

/// Samples of the next round.
renderer::SampleBudget BudgetOfRound(const StageContext& context, const FitState& state);

/// One round: fresh samples, a linearisation of every fitted view, one accepted step (or none), the
/// gauge. Moves state.scene, the step control, averages and histories. `source` must show
/// state.scene, and does again afterwards. The report's costs and PSNR are of the round's start
/// (its samples knew nothing of the point, so they are unbiased). `state` is unchanged if it
/// throws. On ranks other than the first it renders what they are dealt, and leaves state and
/// report alone.
RoundReport RunRound(const StageContext& context, ImageSource& source, FitState& state);

}  // namespace pathfit::optim
