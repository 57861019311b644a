#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/output/figures.h"

namespace pathfit::optim {
// A name that is not known counts as the first.
NLOHMANN_JSON_SERIALIZE_ENUM(GaugeSource,
                             {{GaugeSource::kPhotos, "photos"},
                              {GaugeSource::kKnownLight, "known_light"},
                              {GaugeSource::kKnownColor, "known_color"},
                              {GaugeSource::kMeanColor, "mean_color"},
                              {GaugeSource::kNothing, "nothing"}})
}  // namespace pathfit::optim

namespace pathfit::app {

enum class RunStatus { kRunning, kFinished, kStopped, kFailed };
// A name that is not known counts as failed.
NLOHMANN_JSON_SERIALIZE_ENUM(RunStatus,
                             {{RunStatus::kFailed, "failed"},
                              {RunStatus::kRunning, "running"},
                              {RunStatus::kFinished, "finished"},
                              {RunStatus::kStopped, "stopped"}})

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

struct RunHost {
  std::string name;
  std::string cpu;
  int logical_cpus = 0;
};

/// Content of run.json.
struct RunRecord {
  std::string name;
  std::string program_version;
  std::string build;                             ///< compiler and build type
  std::map<std::string, std::string> libraries;  ///< name and version
  RunHost host;                                  ///< of the last session
  int threads = 0;
  std::uint64_t seed = 0;
  std::string config_path;
  std::string resolved_sha256;  ///< of config.resolved.yaml; empty in records of older versions
  std::vector<InputFile> inputs;
  std::vector<std::string> assumptions;
  std::vector<std::string> warnings;
  std::optional<optim::GaugeReport> gauge;  ///< of the scale that colours and lights share
  std::vector<std::string> attributions;    ///< credits of the photos and meshes that were used
  RunStatus status = RunStatus::kRunning;
  std::string reason;            ///< why it ended, for people
  std::optional<int> exit_code;  ///< of the last session
  std::string started_utc;
  std::string ended_utc;
  double wall_s = 0.0;  ///< of all sessions
  double peak_rss_mb = 0.0;
  std::vector<RunSession> sessions;
  std::vector<optim::StageReport> stages;  ///< without their views
};

template <>
struct Fields<InputFile> {
  static void Visit(auto& file, const auto& visit) {
    visit("path", file.path);
    visit("bytes", file.bytes);
    visit("sha256", file.sha256);
  }
};

template <>
struct Fields<RunHost> {
  static void Visit(auto& host, const auto& visit) {
    visit("name", host.name);
    visit("cpu", host.cpu);
    visit("logical_cpus", host.logical_cpus);
  }
};

template <>
struct Fields<RunSession> {
  static void Visit(auto& session, const auto& visit) {
    visit("argv", session.argv);
    visit("pid", session.pid);
    visit("started_utc", session.started_utc);
    visit("ended_utc", session.ended_utc);
    visit("from_step", session.from_step);
    visit("outcome", session.outcome);
  }
};

/// In words: which rule was in force and what came of it.
std::string GaugeSentence(const optim::GaugeReport& gauge);
/// Whether colours or lights could not be scaled as the gauge's rule wants it.
bool MissesItsRule(const optim::GaugeReport& gauge);

template <>
struct Fields<optim::GaugeReport> {
  static void Visit(auto& gauge, const auto& visit) {
    std::string sentence = GaugeSentence(gauge);  // written for readers, not read back
    visit("rule", gauge.source);
    visit(Figure{.key = "known"}, gauge.known);
    visit("sentence", sentence);
    visit("mean_color", gauge.mean);
    visit("wanted_color", gauge.wanted);
    visit("start_color", gauge.start);
    visit(Figure{.key = "of_exposures"}, gauge.is_of_exposures);
    visit(Figure{.key = "factors"}, gauge.factors);
  }
};

template <>
struct Fields<RunRecord> {
  static void Visit(auto& record, const auto& visit) {
    visit("name", record.name);
    visit("status", record.status);
    visit("reason", record.reason);
    visit("exit_code", record.exit_code);
    visit("started_utc", record.started_utc);
    visit("ended_utc", record.ended_utc);
    visit("wall_s", record.wall_s);
    visit("peak_rss_mb", record.peak_rss_mb);
    visit("program_version", record.program_version);
    visit("build", record.build);
    visit("libraries", record.libraries);
    visit("host", record.host);
    visit("threads", record.threads);
    visit("seed", record.seed);
    visit("config_path", record.config_path);
    visit(Figure{.key = "resolved_sha256"}, record.resolved_sha256);
    visit("sessions", record.sessions);
    visit("stages", record.stages);
    visit(Figure{.key = "gauge"}, record.gauge);
    visit("assumptions", record.assumptions);
    visit("warnings", record.warnings);
    visit("attributions", record.attributions);
    visit("inputs", record.inputs);
  }
};

/// The record's status name, or "killed" when it says running but its process is gone, or nothing
/// holds the lock of the run's folder: of other machines, and where processes have other numbers.
std::string EffectiveStatus(const RunRecord& record, const std::filesystem::path& root);

/// Those of the run's input files that are not what they were when it began, or are gone.
std::vector<std::string> ChangedInputs(const RunRecord& record);

/// A record with host, CPU, pid and times filled in, and one session with these arguments.
RunRecord MakeRunRecord(const std::vector<std::string>& argv);
/// Size and SHA-256 of each file. Throws IoError when one cannot be read.
std::vector<InputFile> HashInputs(const std::vector<std::filesystem::path>& paths);

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
  void SetStages(std::vector<optim::StageReport> stages);
  void SetWarnings(std::vector<std::string> warnings);
  void SetGauge(const std::optional<optim::GaugeReport>& gauge);
  void SetTimes(double wall_s, double peak_rss_mb);
  void Finish(RunStatus status, const std::string& reason, int exit_code);

 private:
  void Write() const { WriteRunRecord(path_, record_); }

  std::filesystem::path path_;
  RunRecord record_;
  bool finished_ = false;
};

}  // namespace pathfit::app
