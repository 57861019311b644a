#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/output/figures.h"

namespace pathfit::app {

/// One line of parameters.csv and of the report: a scalar, or a group of many scalars summed up.
struct ParameterSummary {
  std::string name;  ///< "axe.vertices", "room.intensity.r"
  std::string unit;  ///< "m", "1", "ratio" ...
  std::int64_t num_scalars = 1;
  double initial = 0.0;  ///< value, or mean of the group (NaN for positions)
  double value = 0.0;    ///< the same at the end
  /// Of the value, by what is left unexplained in the photos and by the renderings' noise; NaN
  /// where it is not known, infinite where no photo tells it. Of a group the median of those known.
  double standard_error = 0.0;
  double minimum = 0.0;  ///< of the final values
  double maximum = 0.0;
  double rms_change = 0.0;   ///< root mean square of final - initial
  double lower_bound = 0.0;  ///< infinite when there is none
  double upper_bound = 0.0;
  std::int64_t num_at_bound = 0;
  std::int64_t num_undetermined = 0;  ///< scalars that no photo tells
  bool held = false;
};

template <>
struct Fields<ParameterSummary> {
  static void Visit(auto& p, const auto& visit) {
    visit("name", p.name);
    visit("unit", p.unit);
    visit("num_scalars", p.num_scalars);
    visit("initial", p.initial);
    visit("value", p.value);
    visit("standard_error", p.standard_error);
    visit("minimum", p.minimum);
    visit("maximum", p.maximum);
    visit("rms_change", p.rms_change);
    visit("lower_bound", p.lower_bound);
    visit("upper_bound", p.upper_bound);
    visit("num_at_bound", p.num_at_bound);
    visit(Figure{.key = "num_undetermined"}, p.num_undetermined);
    visit("held", p.held);
  }
};

/// A stage's result and the step it came after.
struct StageEntry {
  int after_step = 0;
  optim::StageReport report;
};

template <>
struct Fields<StageEntry> {
  static void Visit(auto& entry, const auto& visit) {
    visit("after_step", entry.after_step);
    Fields<optim::StageReport>::Visit(entry.report, visit);
    visit("views", entry.report.views);
  }
};

/// What a fit has reported so far; kept in history.json so that a report can be made from disk
/// alone.
struct FitHistory {
  std::vector<optim::RoundReport> rounds;  ///< ascending steps
  std::vector<StageEntry> stages;
  std::vector<ParameterSummary> parameters;
  std::vector<double> gain_errors;    ///< standard errors by photo, NaN where they are not known
  double environment_exposure = 0.0;  ///< factor of the environment pictures, 0 = there are none
};

template <>
struct Fields<FitHistory> {
  static void Visit(auto& history, const auto& visit) {
    visit("environment_exposure", history.environment_exposure);
    visit("rounds", history.rounds);
    visit("stages", history.stages);
    visit("parameters", history.parameters);
    visit(Figure{.key = "gain_errors"}, history.gain_errors);
  }
};

/// Adds a round; one with the same or a later step that is there already is replaced by it.
void AddRound(const optim::RoundReport& report, FitHistory& history);
/// Adds a stage's result after the last round; an entry of the same stage is replaced.
void AddStage(const optim::StageReport& report, FitHistory& history);
/// Removes rounds after `step` and stages that ended after it.
void TruncateHistory(int step, FitHistory& history);

/// Through a temporary file. Throws IoError when not writable.
void WriteHistory(const std::filesystem::path& path, const FitHistory& history);
/// Throws IoError naming the file when it is missing or not a history. Figures that an older
/// version did not write have their default.
FitHistory ReadHistory(const std::filesystem::path& path);

}  // namespace pathfit::app
