#include "app/output/run_record.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <thread>

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include "app/output/file_lock.h"
#include "app/output/log.h"
#include "app/output/sha256.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app {
namespace {

constexpr int kRecordVersion = 1;
constexpr int kInternalError = 1;

std::string CpuModel() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string HostName() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : "unknown";
}

RunHost ThisHost() {
  return {HostName(), CpuModel(), static_cast<int>(std::thread::hardware_concurrency())};
}

RunSession NewSession(const std::vector<std::string>& argv, int from_step) {
  RunSession session;
  session.argv = argv;
  session.pid = getpid();
  session.started_utc = UtcIsoNow();
  session.from_step = from_step;
  return session;
}

}  // namespace

std::string EffectiveStatus(const RunRecord& record, const std::filesystem::path& root) {
  if (record.status == RunStatus::kRunning && !record.sessions.empty()) {
    const bool is_gone = record.host.name == HostName() &&
                         kill(record.sessions.back().pid, 0) != 0 && errno == ESRCH;
    if (is_gone || FileLock(root, O_RDONLY | O_DIRECTORY | O_CLOEXEC, LOCK_SH | LOCK_NB).IsHeld()) {
      return "killed";
    }
  }
  return Json(record.status).get<std::string>();
}

std::vector<std::string> ChangedInputs(const RunRecord& record) {
  std::vector<std::string> changed;
  for (const InputFile& input : record.inputs) {
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(input.path, error);
    const bool is_same = !error && bytes == input.bytes && Sha256OfFile(input.path) == input.sha256;
    if (!is_same) changed.push_back(input.path);
  }
  return changed;
}

bool MissesItsRule(const optim::GaugeReport& gauge) {
  constexpr double kReached = 5e-3;
  if (gauge.source != optim::GaugeSource::kMeanColor) return false;
  for (int c = 0; c < 3; ++c) {
    if (std::abs(gauge.mean[c] - gauge.wanted[c]) > kReached * gauge.wanted[c]) return true;
  }
  return false;
}

std::string GaugeSentence(const optim::GaugeReport& gauge) {
  const auto words = [](const renderer::Rgb& c) {
    return fmt::format("{:.4g} {:.4g} {:.4g}", c.r, c.g, c.b);
  };
  std::string how;
  switch (gauge.source) {
    case optim::GaugeSource::kKnownLight:
      how = "by the light '" + gauge.known + "', which is not free";
      break;
    case optim::GaugeSource::kKnownColor:
      how = "by the base colour of '" + gauge.known + "', which is not free";
      break;
    case optim::GaugeSource::kPhotos:
      how =
          "by what the photos show beside colour times light (highlights, light between "
          "surfaces, lights that are seen)";
      break;
    case optim::GaugeSource::kMeanColor:
      how = "by the rule that the mean base colour is " + words(gauge.wanted);
      if (MissesItsRule(gauge)) {
        how += ", which is not reached: colours or lights would leave their bounds";
      }
      break;
    case optim::GaugeSource::kNothing:
      break;
  }
  const std::string others = gauge.is_of_exposures ? "exposures" : "lights";
  std::string scale = "The common scale of base colours and " + others + " is told " + how;
  if (gauge.source == optim::GaugeSource::kNothing) {
    scale = "Nothing tells the common scale of base colours and " + others +
            ": photos of matt surfaces show their product alone, and it is where the fit began and "
            "its bounds and priors left it";
    if (!gauge.is_of_exposures) {
      scale += " (gauge: {rule: auto} keeps the start's mean base colour)";
    }
  }
  return fmt::format(
      "{}; the mean base colour is "
      "{} ({} at the start), {} are {} times those of the start.",
      scale,
      words(gauge.mean),
      words(gauge.start),
      others,
      words(gauge.factors));
}

RunRecord MakeRunRecord(const std::vector<std::string>& argv) {
  RunRecord record;
  record.host = ThisHost();
  record.sessions.push_back(NewSession(argv, 0));
  record.started_utc = record.sessions.back().started_utc;
  return record;
}

std::vector<InputFile> HashInputs(const std::vector<std::filesystem::path>& paths) {
  std::vector<InputFile> inputs;
  for (const std::filesystem::path& path : paths) {
    const std::string sha256 = Sha256OfFile(path);
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(path, error);
    if (error) throw renderer::IoError(path.string() + ": " + error.message());
    inputs.push_back({path.string(), bytes, sha256});
  }
  return inputs;
}

void WriteRunRecord(const std::filesystem::path& path, const RunRecord& record) {
  Json json = {{"version", kRecordVersion}};
  json.update(ToJson(record));
  renderer::WriteFileAtomically(path, JsonText(json) + "\n");
}

RunRecord ReadRunRecord(const std::filesystem::path& path) {
  const std::string text = renderer::ReadWholeFile(path);
  try {
    const Json json = Json::parse(text);
    if (json.at("version") != kRecordVersion) {
      throw renderer::IoError("it was written by another version of the program");
    }
    RunRecord record;
    FromJson(json, record);
    if (record.sessions.empty()) throw renderer::IoError("sessions is empty");
    return record;
  } catch (const Json::parse_error& error) {
    throw renderer::IoError(path.string() + ": is not a run's record: it is no JSON from byte " +
                            std::to_string(error.byte) + " of " + std::to_string(text.size()) +
                            " on");
  } catch (const std::exception& error) {
    throw renderer::IoError(path.string() + ": is not a run's record: " + error.what());
  }
}

RunRecordFile::RunRecordFile(std::filesystem::path path, RunRecord record)
    : path_(std::move(path)), record_(std::move(record)) {
  PATHFIT_CHECK(!record_.sessions.empty());
  record_.status = RunStatus::kRunning;
  Write();
}

RunRecordFile::RunRecordFile(std::filesystem::path path,
                             const std::vector<std::string>& argv,
                             int from_step)
    : path_(std::move(path)), record_(ReadRunRecord(path_)) {
  record_.status = RunStatus::kRunning;
  record_.reason.clear();
  record_.exit_code.reset();
  record_.ended_utc.clear();
  record_.host = ThisHost();
  record_.sessions.push_back(NewSession(argv, from_step));
  Write();
}

RunRecordFile::~RunRecordFile() {
  if (finished_) return;
  try {
    Finish(RunStatus::kFailed, "ended by an error; see log.txt", kInternalError);
  } catch (const std::exception&) {
    // The disk is gone as well; the exception that is passing through says more.
    return;
  }
}

void RunRecordFile::SetStages(std::vector<optim::StageReport> stages) {
  record_.stages = std::move(stages);
  Write();
}

void RunRecordFile::SetWarnings(std::vector<std::string> warnings) {
  if (warnings == record_.warnings) return;
  record_.warnings = std::move(warnings);
  Write();
}

void RunRecordFile::SetGauge(const std::optional<optim::GaugeReport>& gauge) {
  record_.gauge = gauge;
  Write();
}

void RunRecordFile::SetTimes(double wall_s, double peak_rss_mb) {
  record_.wall_s = wall_s;
  record_.peak_rss_mb = std::max(record_.peak_rss_mb, peak_rss_mb);
  Write();
}

void RunRecordFile::Finish(RunStatus status, const std::string& reason, int exit_code) {
  record_.status = status;
  record_.reason = reason;
  record_.exit_code = exit_code;
  record_.ended_utc = UtcIsoNow();
  record_.sessions.back().ended_utc = record_.ended_utc;
  record_.sessions.back().outcome = Json(status).get<std::string>();
  finished_ = true;
  Write();
}

}  // namespace pathfit::app
