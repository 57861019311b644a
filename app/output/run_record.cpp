#include "app/output/run_record.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <limits>
#include <thread>

#include <nlohmann/json.hpp>
#include <signal.h>
#include <unistd.h>

#include "app/output/sha256.h"
#include "app/output/utc_time.h"
#include "renderer/core/check.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kRecordVersion = 1;
constexpr std::array<std::string_view, 4> kStatusNames = {
    "running", "finished", "stopped", "failed"};
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

RunSession NewSession(const std::vector<std::string>& argv, int from_step) {
  RunSession session;
  session.argv = argv;
  session.pid = getpid();
  session.started_utc = UtcIsoNow();
  session.from_step = from_step;
  return session;
}

Json NumberJson(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

double NumberFrom(const Json& json) {
  return json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

Json SessionsJson(const RunRecord& record) {
  Json sessions = Json::array();
  for (const RunSession& session : record.sessions) {
    sessions.push_back({{"argv", session.argv},
                        {"pid", session.pid},
                        {"started_utc", session.started_utc},
                        {"ended_utc", session.ended_utc},
                        {"from_step", session.from_step},
                        {"outcome", session.outcome}});
  }
  return sessions;
}

Json StagesJson(const RunRecord& record) {
  Json stages = Json::array();
  for (const StageSummary& stage : record.stages) {
    stages.push_back({{"stage", stage.stage},
                      {"rounds", stage.rounds},
                      {"wall_s", NumberJson(stage.wall_s)},
                      {"psnr_srgb_fit_db", NumberJson(stage.psnr_srgb_fit)},
                      {"psnr_srgb_val_db", NumberJson(stage.psnr_srgb_val)},
                      {"iou_fit", NumberJson(stage.iou_fit)},
                      {"iou_val", NumberJson(stage.iou_val)},
                      {"stop_reason", stage.stop_reason}});
  }
  return stages;
}

Json ToJson(const RunRecord& record) {
  Json libraries = Json::object();
  for (const auto& [library, version] : record.libraries) libraries[library] = version;
  Json inputs = Json::array();
  for (const InputFile& input : record.inputs) {
    inputs.push_back({{"path", input.path}, {"bytes", input.bytes}, {"sha256", input.sha256}});
  }
  Json json = {{"version", kRecordVersion},
               {"name", record.name},
               {"status", StatusName(record.status)},
               {"reason", record.reason},
               {"exit_code", record.exit_code ? Json(*record.exit_code) : Json(nullptr)},
               {"started_utc", record.started_utc},
               {"ended_utc", record.ended_utc},
               {"wall_s", NumberJson(record.wall_s)},
               {"peak_rss_mb", NumberJson(record.peak_rss_mb)},
               {"program_version", record.program_version},
               {"build", record.build},
               {"libraries", std::move(libraries)}};
  json["host"] = {
      {"name", record.host}, {"cpu", record.cpu}, {"logical_cpus", record.logical_cpus}};
  json["threads"] = record.threads;
  json["seed"] = record.seed;
  json["config_path"] = record.config_path;
  json["sessions"] = SessionsJson(record);
  json["stages"] = StagesJson(record);
  json["assumptions"] = record.assumptions;
  json["warnings"] = record.warnings;
  json["attributions"] = record.attributions;
  json["inputs"] = std::move(inputs);
  return json;
}

void ReadLists(const Json& json, RunRecord& record) {
  for (const auto& [library, version] : json.at("libraries").items()) {
    record.libraries.emplace_back(library, version.get<std::string>());
  }
  for (const Json& input : json.at("inputs")) {
    record.inputs.push_back({input.at("path").get<std::string>(),
                             input.at("bytes").get<std::uint64_t>(),
                             input.at("sha256").get<std::string>()});
  }
  for (const Json& entry : json.at("sessions")) {
    RunSession& session = record.sessions.emplace_back();
    entry.at("argv").get_to(session.argv);
    entry.at("pid").get_to(session.pid);
    entry.at("started_utc").get_to(session.started_utc);
    entry.at("ended_utc").get_to(session.ended_utc);
    entry.at("from_step").get_to(session.from_step);
    entry.at("outcome").get_to(session.outcome);
  }
  for (const Json& entry : json.at("stages")) {
    StageSummary& stage = record.stages.emplace_back();
    entry.at("stage").get_to(stage.stage);
    entry.at("rounds").get_to(stage.rounds);
    stage.wall_s = NumberFrom(entry.at("wall_s"));
    stage.psnr_srgb_fit = NumberFrom(entry.at("psnr_srgb_fit_db"));
    stage.psnr_srgb_val = NumberFrom(entry.at("psnr_srgb_val_db"));
    stage.iou_fit = NumberFrom(entry.at("iou_fit"));
    stage.iou_val = NumberFrom(entry.at("iou_val"));
    entry.at("stop_reason").get_to(stage.stop_reason);
  }
  json.at("assumptions").get_to(record.assumptions);
  json.at("warnings").get_to(record.warnings);
  json.at("attributions").get_to(record.attributions);
}

RunRecord FromJson(const Json& json) {
  RunRecord record;
  const auto status =
      std::find(kStatusNames.begin(), kStatusNames.end(), json.at("status").get<std::string>());
  record.status = status == kStatusNames.end()
                      ? RunStatus::kFailed
                      : static_cast<RunStatus>(status - kStatusNames.begin());
  json.at("name").get_to(record.name);
  json.at("reason").get_to(record.reason);
  if (json.at("exit_code").is_number()) record.exit_code = json.at("exit_code").get<int>();
  json.at("started_utc").get_to(record.started_utc);
  json.at("ended_utc").get_to(record.ended_utc);
  record.wall_s = NumberFrom(json.at("wall_s"));
  record.peak_rss_mb = NumberFrom(json.at("peak_rss_mb"));
  json.at("program_version").get_to(record.program_version);
  json.at("build").get_to(record.build);
  json.at("host").at("name").get_to(record.host);
  json.at("host").at("cpu").get_to(record.cpu);
  json.at("host").at("logical_cpus").get_to(record.logical_cpus);
  json.at("threads").get_to(record.threads);
  json.at("seed").get_to(record.seed);
  json.at("config_path").get_to(record.config_path);
  ReadLists(json, record);
  if (record.sessions.empty()) throw renderer::IoError("sessions is empty");
  return record;
}

}  // namespace

std::string StatusName(RunStatus status) {
  return std::string(kStatusNames[static_cast<std::size_t>(status)]);
}

std::string EffectiveStatus(const RunRecord& record) {
  if (record.status != RunStatus::kRunning || record.sessions.empty()) {
    return StatusName(record.status);
  }
  if (record.host != HostName()) return StatusName(record.status);
  const bool gone = kill(record.sessions.back().pid, 0) != 0 && errno == ESRCH;
  return gone ? "killed" : StatusName(record.status);
}

RunRecord MakeRunRecord(const std::vector<std::string>& argv) {
  RunRecord record;
  record.host = HostName();
  record.cpu = CpuModel();
  record.logical_cpus = static_cast<int>(std::thread::hardware_concurrency());
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

StageSummary SummarizeStage(const optim::StageReport& report) {
  const bool validation =
      std::any_of(report.views.begin(), report.views.end(), [](const optim::ViewReport& view) {
        return view.validation;
      });
  const double none = std::numeric_limits<double>::quiet_NaN();
  return {report.stage,
          report.rounds,
          report.wall_s,
          report.psnr_srgb_fit,
          validation ? report.psnr_srgb_val : none,
          report.iou_fit,
          validation ? report.iou_val : none,
          report.stop_reason};
}

void WriteRunRecord(const std::filesystem::path& path, const RunRecord& record) {
  renderer::WriteFileAtomically(
      path, ToJson(record).dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

RunRecord ReadRunRecord(const std::filesystem::path& path) {
  const std::string text = renderer::ReadWholeFile(path);
  try {
    const Json json = Json::parse(text);
    if (json.at("version") != kRecordVersion) {
      throw renderer::IoError("it was written by another version of the program");
    }
    return FromJson(json);
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
  record_.host = HostName();
  record_.cpu = CpuModel();
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

void RunRecordFile::SetStages(std::vector<StageSummary> stages) {
  record_.stages = std::move(stages);
  Write();
}

void RunRecordFile::SetWarnings(std::vector<std::string> warnings) {
  if (warnings == record_.warnings) return;
  record_.warnings = std::move(warnings);
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
  record_.sessions.back().outcome = StatusName(status);
  finished_ = true;
  Write();
}

}  // namespace pathfit::app
