#pragma once

#include <string>
#include <vector>

#include "app/output/fit_history.h"
#include "app/output/log.h"
#include "app/output/parameter_table.h"
#include "app/output/progress.h"
#include "app/output/run_directory.h"
#include "app/output/run_record.h"
#include "optim/observation/observation.h"
#include "optim/round/fit_report.h"
#include "optim/round/fit_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::app {

struct RecorderOptions {
  bool report = true;  ///< whether report.html is written
  /// Name of the one stage after which the large pictures of held-out views are written; empty:
  /// after every stage. The report's small ones always follow the newest stage.
  std::string only_pictures_of = {};
};

/// Writes down what a fit reports: progress, log, metrics.csv, history.json, run.json and images;
/// report.html after every stage and at the end. Everything a report needs is on disk after each
/// call, so that a resumed run, or a run that was killed, has a complete one.
class FitRecorder final : public optim::FitObserver {
 public:
  /// `resume_step`: rounds done before, 0 for a new run; what later rounds left behind is removed.
  /// The references must outlive the recorder. Throws IoError.
  FitRecorder(const RunDirectory& run,
              const optim::ObservationSet& observations,
              RunRecordFile& record,
              Log& log,
              Progress& progress,
              RecorderOptions options,
              int resume_step);

  void OnRound(const optim::RoundReport& report) override;
  void OnScene(const std::string& stage,
               const renderer::Scene& scene,
               const StandardErrorsByName& standard_errors) override;
  void OnView(const std::string& stage,
              std::size_t view,
              const renderer::Film& film,
              const optim::ViewLevel& observed) override;
  void OnStage(const optim::StageReport& report) override;
  void OnMessage(const std::string& text) override;
  void OnWarning(const std::string& text) override;
  void OnLimit(const std::string& limit) override;

  /// Parameter table and environment pictures, of the run's first scene and its present one, and
  /// the model of the latter.
  void RecordScenes(const optim::FitSpec& spec,
                    const renderer::Scene& start,
                    const renderer::Scene& result,
                    const StandardErrorsByName& errors = {});

  /// Ends the run: run.json gets its final status, and the report is written.
  void Finish(RunStatus status, const std::string& reason, int exit_code);

  [[nodiscard]] const FitHistory& history() const { return history_; }

 private:
  void UpdateRecord();
  /// history.json and metrics.csv
  void WriteRounds() const;
  /// A page that cannot be written ends no fit.
  void WritePage();

  const RunDirectory& run_;
  const optim::ObservationSet& observations_;
  RunRecordFile& record_;
  Log& log_;
  Progress& progress_;
  RecorderOptions options_;
  FitHistory history_;
  std::vector<std::string> view_folders_;
  std::vector<std::string> earlier_warnings_;  ///< of the sessions before this one
};

}  // namespace pathfit::app
