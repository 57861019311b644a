#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "optim/problem/scene_image_source.h"
#include "optim/round/evaluation.h"
#include "optim/round/fit.h"
#include "optim/round/round_runner.h"

namespace pathfit::optim {

/// A fit in progress: stages, checkpoints, reports. Use RunFit.
class FitDriver {
 public:
  FitDriver(renderer::Scene start,
            const ObservationSet& observations,
            const FitSpec& spec,
            FitObserver& observer,
            const FitControls& controls);
  ~FitDriver();
  FitDriver(const FitDriver&) = delete;
  FitDriver& operator=(const FitDriver&) = delete;
  FitResult Run();

 private:
  /// What belongs to the stage at hand.
  struct Stage;
  /// A scene that may end the stage.
  struct Candidate {
    std::string name;
    renderer::Scene scene;
  };

  void Validate() const;
  void Resume();
  void RunStages();
  void ReportStart();
  void StartStage();
  /// False when the time limit leaves no room for another round.
  bool RunRounds();
  void FinishStage(const std::string& stop_reason);
  [[nodiscard]] std::vector<Candidate> StageCandidates() const;
  void ReportStage(StageReport report, const FitViews& views, const SampleHalves& samples);
  void SaveCheckpoint();
  [[nodiscard]] const FitViews& ViewsAt(double scale);
  [[nodiscard]] std::unique_ptr<SceneImageSource> MakeSource(
      const renderer::Scene& scene,
      const renderer::ParameterLayout& layout,
      const FitViews& views) const;
  [[nodiscard]] SampleHalves EvaluationSamples() const;
  [[nodiscard]] double WallSeconds() const;

  const renderer::Scene start_;
  const ObservationSet& observations_;
  const FitSpec& spec_;
  FitObserver& observer_;
  const FitControls& controls_;
  ExposureModel exposure_;
  ParameterSet all_;  ///< every unknown that is not held: the order of states
  bool fits_exposure_ = false;

  renderer::Scene scene_;
  FitState state_;
  FitResult result_;
  std::unique_ptr<Stage> stage_;
  std::unique_ptr<FitViews> views_;
  double views_scale_ = 0.0;
  double session_start_wall_s_ = 0.0;
  std::chrono::steady_clock::time_point session_start_;
};

}  // namespace pathfit::optim
