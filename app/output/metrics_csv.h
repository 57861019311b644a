#pragma once

#include <filesystem>
#include <string>

#include "optim/round/fit_report.h"

namespace pathfit::app {

/// metrics.csv: a fixed header and one row per round, in the order of steps. The file is complete
/// after every call. Numbers are written so that reading gives the same double; what is not finite
/// is an empty cell.
class MetricsCsv {
 public:
  /// Starts the file, or continues it after `last_step`: later rows and a torn last line are
  /// removed, so that a run that was killed and resumed has the rows of one that was not. Throws
  /// IoError: not a metrics file, not writable.
  MetricsCsv(std::filesystem::path path, int last_step);

  /// Appends a row. A step that is there already replaces it and all rows after it.
  void Append(const optim::RoundReport& report);

  static std::string Header();
  static std::string Row(const optim::RoundReport& report);

 private:
  void RemoveRowsAfter(int step);

  std::filesystem::path path_;
  int last_step_ = 0;
};

/// A cell of a CSV file: quoted when it holds a comma, quote or line break.
std::string CsvCell(const std::string& text);
/// Shortest decimal form that reads back to the same double; empty when not finite.
std::string CsvNumber(double value);

}  // namespace pathfit::app
