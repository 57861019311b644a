#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "optim/checkpoint/fit_state.h"
#include "optim/observation/observation.h"
#include "optim/round/fit_report.h"
#include "optim/round/fit_spec.h"
#include "renderer/core/parallel.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

class Ranks;

enum class FitStatus { kFinished, kStageReached, kCancelled, kTimeLimit };

struct FitControls {
  /// Polled while rendering. The fit then returns the scene of the last finished round.
  const renderer::CancelFlag* cancel = nullptr;
  std::filesystem::path checkpoint_folder;  ///< written after every round; empty = none
  std::optional<FitState> resume;           ///< continue from here instead of from the start
  std::string stop_after;                   ///< name of the stage to end after; empty: the last
  /// Share the work, with the same bits for any number of them: all call RunFit with the same
  /// start, observations and specification. The first alone uses the checkpoints' folder and
  /// `resume`, and gets the result; the others have a SilentObserver, return nothing, and throw
  /// RanksStopped if the first ends early. Null: this process alone.
  Ranks* ranks = nullptr;
};

struct FitResult {
  renderer::Scene scene;
  FitStatus status = FitStatus::kFinished;
  std::vector<StageReport> stages;  ///< of this session
  /// By group of unknowns ("sky.intensity"), one per scalar in its unit: by the noise of renderings
  /// and photos alike, from stages of few unknowns (ImageProblem::kMaxGramScalars), else NaN;
  /// infinite where no photo tells it.
  std::map<std::string, std::vector<double>> standard_errors;
  /// What fixed the scale that colours and lights share; nothing if no stage frees both.
  std::optional<GaugeReport> gauge;
  int rounds = 0;       ///< of all sessions
  double wall_s = 0.0;  ///< of all sessions
};

/// Fits `start` to the photos. scene.sensors[i] is the camera of view i (its gain is used, its pose
/// is the view's). The scene returned never costs more than `start` on one common sample set of the
/// last stage; a stage never ends worse than it began. Held-out views are never fitted; if
/// exposures are unknown, the one gain of each is estimated from its own photo, and reports say so.
/// The time limit (FitSpec::time_limit_s) counts this session; it is checked between rounds, and a
/// round that is expected not to fit is not begun. The stage's best candidate is then returned; the
/// checkpoint still is the last round. Throws: SceneError (views and sensors do not match, nothing
/// to fit, unknowns that do not exist), MemoryError, NumericalError, IoError (checkpoints; a
/// resumed state of another specification).
FitResult RunFit(const renderer::Scene& start,
                 const ObservationSet& observations,
                 const FitSpec& spec,
                 FitObserver& observer,
                 const FitControls& controls);

}  // namespace pathfit::optim
