#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "optim/round/fit_report.h"

namespace pathfit::app {

/// One line of parameters.csv and of the report: a scalar, or a group of many scalars summed up.
struct ParameterSummary {
  std::string name;  ///< "axe.vertices", "room.intensity.r"
  std::string unit;  ///< "m", "1", "ratio" ...
  std::int64_t num_scalars = 1;
  double initial = 0.0;  ///< value, or mean of the group (NaN for positions)
  double final = 0.0;
  double minimum = 0.0;  ///< of the final values
  double maximum = 0.0;
  double rms_change = 0.0;  ///< root mean square of final - initial
  double lower = 0.0;       ///< bounds, infinite when there is none
  double upper = 0.0;
  std::int64_t num_at_bound = 0;
  bool hold = false;
};

/// A stage's result and the step it came after.
struct StageEntry {
  int after_step = 0;
  optim::StageReport report;
};

/// What a fit has reported so far; kept in history.json so that a report can be made from disk
/// alone.
struct FitHistory {
  std::vector<optim::RoundReport> rounds;  ///< ascending steps
  std::vector<StageEntry> stages;
  std::vector<ParameterSummary> parameters;
  double environment_exposure = 0.0;  ///< factor of the environment pictures, 0 = there are none
};

/// Adds a round; one with the same or a later step that is there already is replaced by it.
void AddRound(const optim::RoundReport& report, FitHistory& history);
/// Adds a stage's result after the last round; an entry of the same stage is replaced.
void AddStage(const optim::StageReport& report, FitHistory& history);
/// Removes rounds after `step` and stages that ended after it.
void TruncateHistory(int step, FitHistory& history);

void WriteHistory(const std::filesystem::path& path, const FitHistory& history);
/// Throws IoError naming the file when it is missing or not a history.
FitHistory ReadHistory(const std::filesystem::path& path);

}  // namespace pathfit::app
