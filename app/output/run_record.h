#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "optim/round/fit_report.h"

namespace pathfit::app {

enum class RunStatus { kRunning, kFinished, kStopped, kFailed };

struct InputFile {
  std::string path;
  std::uint64_t bytes = 0;
  std::string sha256;
};

/// One process that worked on the run: `fit`, then every `resume`.
struct RunSession {
  std::vector<std::string> argv;
  int pid = 0;
  std::string started_utc;
  std::string ended_utc;  ///< empty while it runs, or when it was killed
  int from_step = 0;      ///< rounds that were done before
  std::string outcome;    ///< status name, empty like ended_utc
};

struct StageSummary {
  std::string stage;
  int rounds = 0;
  double wall_s = 0.0;                              ///< since the run began
  double psnr_srgb_fit = 0.0, psnr_srgb_val = 0.0;  ///< val: NaN without held-out views
  double iou_fit = 0.0, iou_val = 0.0;
  std::string stop_reason;
};

/// Content of run.json.
struct RunRecord {
  std::string name;
  std::string program_version;
  std::string build;  ///< compiler and build type
  std::vector<std::pair<std::string, std::string>> libraries;
  std::string host;
  std::string cpu;
  int logical_cpus = 0;
  int threads = 0;
  std::uint64_t seed = 0;
  std::string config_path;
  std::vector<InputFile> inputs;
  std::vector<std::string> assumptions;
  std::vector<std::string> warnings;
  std::vector<std::string> attributions;  ///< credits of the photos and meshes that were used
  RunStatus status = RunStatus::kRunning;
  std::string reason;            ///< why it ended, for people
  std::optional<int> exit_code;  ///< of the last session
  std::string started_utc;
  std::string ended_utc;
  double wall_s = 0.0;  ///< of all sessions
  double peak_rss_mb = 0.0;
  std::vector<RunSession> sessions;
  std::vector<StageSummary> stages;
};

std::string StatusName(RunStatus status);
/// The record's status name, or "killed" when it says running but its process is gone.
std::string EffectiveStatus(const RunRecord& record);

/// A record with host, CPU, pid and times filled in, and one session with these arguments.
RunRecord MakeRunRecord(const std::vector<std::string>& argv);
/// Size and SHA-256 of each file. Throws IoError when one cannot be read.
std::vector<InputFile> HashInputs(const std::vector<std::filesystem::path>& paths);
StageSummary SummarizeStage(const optim::StageReport& report);

void WriteRunRecord(const std::filesystem::path& path, const RunRecord& record);
/// Throws IoError naming the file when it is missing or malformed.
RunRecord ReadRunRecord(const std::filesystem::path& path);

/// run.json during a run: written as "running" on construction and after every change. If nobody
/// says how the run ended before destruction, an exception is passing through: the record then says
/// "failed".
class RunRecordFile {
 public:
  /// A new run.
  RunRecordFile(std::filesystem::path path, RunRecord record);
  /// Continues a run from its file: a session is added, the earlier status is overridden.
  RunRecordFile(std::filesystem::path path, const std::vector<std::string>& argv, int from_step);
  RunRecordFile(const RunRecordFile&) = delete;
  RunRecordFile& operator=(const RunRecordFile&) = delete;
  ~RunRecordFile();

  [[nodiscard]] const RunRecord& record() const { return record_; }
  void SetStages(std::vector<StageSummary> stages);
  void SetWarnings(std::vector<std::string> warnings);
  void SetTimes(double wall_s, double peak_rss_mb);
  void Finish(RunStatus status, const std::string& reason, int exit_code);

 private:
  void Write() const { WriteRunRecord(path_, record_); }

  std::filesystem::path path_;
  RunRecord record_;
  bool finished_ = false;
};

}  // namespace pathfit::app
