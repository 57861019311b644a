#include "app/output/fit_history.h"

#include <algorithm>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app {
namespace {

constexpr int kHistoryVersion = 2;

}  // namespace

void AddRound(const optim::RoundReport& report, FitHistory& history) {
  std::erase_if(history.rounds,
                [&](const optim::RoundReport& old) { return old.step >= report.step; });
  history.rounds.push_back(report);
}

void AddStage(const optim::StageReport& report, FitHistory& history) {
  std::erase_if(history.stages,
                [&](const StageEntry& old) { return old.report.stage == report.stage; });
  const int step = history.rounds.empty() ? 0 : history.rounds.back().step;
  history.stages.push_back({step, report});
}

void TruncateHistory(int step, FitHistory& history) {
  std::erase_if(history.rounds, [&](const optim::RoundReport& old) { return old.step > step; });
  std::erase_if(history.stages, [&](const StageEntry& old) { return old.after_step > step; });
}

void WriteHistory(const std::filesystem::path& path, const FitHistory& history) {
  Json json = {{"version", kHistoryVersion}};
  json.update(ToJson(history));
  renderer::WriteFileAtomically(path, JsonText(json, 1) + "\n");
}

FitHistory ReadHistory(const std::filesystem::path& path) {
  const std::string text = renderer::ReadWholeFile(path);
  try {
    const Json json = Json::parse(text);
    if (json.at("version") != kHistoryVersion) {
      throw renderer::IoError(path.string() + ": was written by another version of the program");
    }
    FitHistory history;
    FromJson(json, history);
    return history;
  } catch (const Json::parse_error& error) {
    throw renderer::IoError(path.string() + ": is damaged: it is no JSON from byte " +
                            std::to_string(error.byte) + " of " + std::to_string(text.size()) +
                            " on");
  } catch (const Json::exception&) {
    throw renderer::IoError(path.string() + ": is damaged: it is not a run's history");
  }
}

}  // namespace pathfit::app
