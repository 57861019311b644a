#include "app/output/report_data.h"

#include <algorithm>

#include "renderer/io/atomic_file.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;

std::string ReadIfThere(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) ? renderer::ReadWholeFile(path) : std::string();
}

std::vector<ReportView> LoadViews(const RunDirectory& run, const FitHistory& history) {
  const optim::StageReport* last = LastReport(history);
  if (last == nullptr) return {};
  std::vector<std::string> names;
  for (const optim::ViewReport& view : last->views) names.push_back(view.name);
  const std::vector<std::string> folders = ViewFolderNames(names);
  const optim::StageReport* start = StartReport(history);
  std::vector<ReportView> views;
  for (std::size_t i = 0; i < folders.size(); ++i) {
    ReportView& view = views.emplace_back();
    view.last = last->views[i];
    view.has_start = start != nullptr && start != last && i < start->views.size();
    if (view.has_start) view.start = start->views[i];
    const auto read = [&](const char* kind) {
      return ReadIfThere(ThumbnailPath(run, folders[i], kind));
    };
    view.photo = read("photo");
    view.start_fit = read("start");
    view.result_fit = read("result");
    view.difference = read("difference");
    view.silhouette = read("silhouette");
  }
  return views;
}

}  // namespace

const optim::StageReport* StartReport(const FitHistory& history) {
  const auto found =
      std::find_if(history.stages.begin(), history.stages.end(), [](const StageEntry& entry) {
        return entry.report.stage == "start";
      });
  return found == history.stages.end() ? nullptr : &found->report;
}

const optim::StageReport* LastReport(const FitHistory& history) {
  return history.stages.empty() ? nullptr : &history.stages.back().report;
}

bool HasValidation(const optim::StageReport& report) {
  return std::any_of(report.views.begin(), report.views.end(), [](const optim::ViewReport& view) {
    return view.validation;
  });
}

fs::path ThumbnailPath(const RunDirectory& run,
                       const std::string& view_folder,
                       const std::string& kind) {
  return run.Images() / view_folder / ("thumbnail_" + kind + ".jpg");
}

ReportData LoadReportData(const RunDirectory& run) {
  ReportData data;
  data.run_path = run.root().string();
  data.record = ReadRunRecord(run.Record());
  data.status = EffectiveStatus(data.record);
  if (fs::exists(run.History())) data.history = ReadHistory(run.History());
  data.config = ReadIfThere(run.Config());
  data.resolved_config = ReadIfThere(run.ResolvedConfig());
  data.views = LoadViews(run, data.history);
  data.environment_initial = ReadIfThere(run.Images() / "environment_initial.png");
  data.environment_final = ReadIfThere(run.Images() / "environment_final.png");
  return data;
}

}  // namespace pathfit::app
