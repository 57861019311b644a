#include "app/output/comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <fmt/format.h>

#include "app/config/utf8.h"
#include "app/config/yaml_document.h"
#include "app/output/progress.h"
#include "app/output/sha256.h"
#include "app/output/terminal.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostViews = 12;
constexpr std::size_t kMostDifferences = 40;  // in the table of the terminal
constexpr std::size_t kWidestValue = 40;

const optim::StageReport* LastStage(const ComparedRun& run) {
  const auto& stages = run.data.history.stages;
  return stages.empty() ? nullptr : &stages.back().report;
}

/// All labels of one kind, if they tell the runs apart.
template <class Label>
bool Relabel(std::vector<ComparedRun>& runs, Label label) {
  std::set<std::string> seen;
  for (ComparedRun& run : runs) {
    run.label = label(run);
    seen.insert(run.label);
  }
  return seen.size() == runs.size();
}

/// Such as [1, [2, 3]].
std::string ListText(const YamlNode& list) {
  std::string text;
  for (const YamlNode& item : list.items) {
    text += (text.empty() ? "" : ", ") + (item.IsList() ? ListText(item) : item.text);
  }
  return "[" + text + "]";
}

/// Scalars and lists of them by their full key; stages and the like by their name.
void Flatten(const YamlNode& node,
             const std::string& key,
             std::map<std::string, std::string>& out) {
  const auto below = [&](const std::string& name) { return key.empty() ? name : key + "." + name; };
  for (const YamlEntry& entry : node.entries) Flatten(entry.value, below(entry.key), out);
  const bool is_plain =
      std::ranges::none_of(node.items, [](const YamlNode& item) { return item.IsMap(); });
  if (node.IsList() && is_plain) {
    out[key] = ListText(node);
  } else if (node.IsList()) {
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const YamlNode* name = node.items[i].Find("name");
      Flatten(node.items[i], below(name != nullptr ? name->text : std::to_string(i)), out);
    }
  } else if (!node.IsMap()) {
    out[key] = node.text;
  } else if (node.entries.empty()) {
    out[key] = "{}";
  }
}

std::map<std::string, std::string> SettingsOf(const ComparedRun& run) {
  std::map<std::string, std::string> settings;
  if (run.data.resolved_config.empty()) return settings;
  Flatten(ParseYaml(run.data.resolved_config, run.data.run_path + "/config.resolved.yaml").root,
          "",
          settings);
  return settings;
}

/// The start has none that could be compared.
double CostOf(const ComparedRun& run) {
  const optim::StageReport* last = LastStage(run);
  return last == nullptr || last->stage == "start" ? kNan : last->cost_after;
}

template <double optim::StageReport::*member>
double OfLastStage(const ComparedRun& run) {
  const optim::StageReport* last = LastStage(run);
  return last == nullptr ? kNan : last->*member;
}
std::string Decibels(double value) { return fmt::format("{:.2f} dB", value); }
std::string Share(double value) { return fmt::format("{:.4f}", value); }

std::string Shortened(const std::string& text) {
  return text.size() <= kWidestValue ? text : "..." + LastBytes(text, kWidestValue - 3);
}

Json PictureJson(const std::string& jpeg) {
  return jpeg.empty() ? Json(nullptr) : Json(DataUri(jpeg));
}

/// A view of any run, and where it is in each of them.
struct ComparedView {
  std::string name;
  bool validation = false;
  double worst_psnr = std::numeric_limits<double>::infinity();
  std::vector<int> index;  ///< by run, -1 where it is not there
};

std::vector<ComparedView> ViewsOf(const std::vector<ComparedRun>& runs) {
  std::vector<ComparedView> views;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const optim::StageReport* last = LastStage(runs[r]);
    if (last == nullptr) continue;
    for (std::size_t v = 0; v < last->views.size(); ++v) {
      const optim::ViewReport& report = last->views[v];
      auto found = std::ranges::find(views, report.name, &ComparedView::name);
      if (found == views.end()) {
        views.push_back({.name = report.name, .index = std::vector<int>(runs.size(), -1)});
        found = views.end() - 1;
      }
      found->validation = found->validation || report.validation;
      found->index[r] = static_cast<int>(v);
      if (report.psnr_srgb < found->worst_psnr) found->worst_psnr = report.psnr_srgb;
    }
  }
  std::ranges::stable_sort(views, [](const ComparedView& a, const ComparedView& b) {
    return a.validation != b.validation ? a.validation : a.worst_psnr < b.worst_psnr;
  });
  return views;
}

Json ViewJson(const ComparedView& view, const std::vector<ComparedRun>& runs) {
  Json json = {{"name", view.name},
               {"validation", view.validation},
               {"photo", nullptr},
               {"results", Json::array()}};
  const std::string* shown = nullptr;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    Json result = {
        {"photo", nullptr}, {"picture", nullptr}, {"psnr_srgb_db", nullptr}, {"iou", nullptr}};
    if (view.index[r] >= 0) {
      const auto v = static_cast<std::size_t>(view.index[r]);
      const optim::ViewReport& report = LastStage(runs[r])->views[v];
      result["psnr_srgb_db"] = ToJson(report.psnr_srgb);
      result["iou"] = ToJson(report.iou);
      const auto& all = runs[r].data.view_pictures;
      if (v < all.size()) {
        if (const auto found = all[v].find("result"); found != all[v].end()) {
          result["picture"] = PictureJson(found->second);
        }
        const auto photo = all[v].find("photo");
        if (photo != all[v].end() && !photo->second.empty() &&
            (shown == nullptr || photo->second != *shown)) {
          (shown == nullptr ? json : result)["photo"] = PictureJson(photo->second);
          if (shown == nullptr) shown = &photo->second;
        }
      }
    }
    json["results"].push_back(std::move(result));
  }
  return json;
}

}  // namespace

const std::vector<FigureColumn>& FigureColumns() {
  using optim::StageReport;
  static const std::vector<FigureColumn> columns = {
      {"psnr_srgb_val_db",
       "PSNR sRGB held out",
       OfLastStage<&StageReport::psnr_srgb_val>,
       Decibels},
      {"psnr_srgb_fit_db", "PSNR sRGB fitted", OfLastStage<&StageReport::psnr_srgb_fit>, Decibels},
      {"iou_val", "IoU held out", OfLastStage<&StageReport::iou_val>, Share},
      {"iou_fit", "IoU fitted", OfLastStage<&StageReport::iou_fit>, Share},
      {"cost_after", "Cost", CostOf, [](double value) { return fmt::format("{:.3e}", value); }},
      {"rounds",
       "Rounds",
       [](const ComparedRun& run) {
         const auto& rounds = run.data.history.rounds;
         return rounds.empty() ? 0.0 : static_cast<double>(rounds.back().step);
       },
       [](double value) { return fmt::format("{:.0f}", value); }},
      {"wall_s",
       "Time",
       [](const ComparedRun& run) { return run.data.record.wall_s; },
       [](double value) { return DurationText(value); }},
      {"peak_rss_mb",
       "Memory",
       [](const ComparedRun& run) { return run.data.record.peak_rss_mb; },
       [](double value) { return fmt::format("{:.0f} MB", value); }}};
  return columns;
}

std::string AlignedTable(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows.front().size());
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i)
      widths[i] = std::max(widths[i], NumCharacters(row[i]));
  }
  std::string text;
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - NumCharacters(row[i]), ' ');
      const bool is_last = i + 1 == row.size();
      text += i == 0 ? row[i] + (is_last ? "" : space) : "  " + space + row[i];
    }
    text += "\n";
  }
  return text;
}

std::vector<ComparedRun> LoadRuns(const std::vector<RunDirectory>& directories) {
  std::vector<ComparedRun> runs;
  for (const RunDirectory& directory : directories) {
    runs.push_back({"", LoadReportData(directory)});
  }
  const bool labelled =
      Relabel(runs, [](const ComparedRun& run) { return run.data.record.name; }) ||
      Relabel(runs,
              [](const ComparedRun& run) {
                return fs::weakly_canonical(run.data.run_path).filename().string();
              }) ||
      Relabel(runs, [](const ComparedRun& run) { return run.data.run_path; });
  if (!labelled) {
    for (std::size_t i = 0; i < runs.size(); ++i) runs[i].label += " #" + std::to_string(i + 1);
  }
  return runs;
}

std::vector<Difference> DifferencesOf(const std::vector<ComparedRun>& runs) {
  std::vector<std::map<std::string, std::string>> settings;
  std::set<std::string> keys;
  for (const ComparedRun& run : runs) {
    settings.push_back(SettingsOf(run));
    for (const auto& [key, value] : settings.back()) keys.insert(key);
  }
  std::vector<Difference> differences;
  for (const std::string& key : keys) {
    Difference difference{key, {}};
    for (const auto& one : settings) {
      const auto found = one.find(key);
      difference.values.push_back(found == one.end() ? "-" : found->second);
    }
    const std::string& first = difference.values.front();
    if (std::ranges::any_of(difference.values, [&](const auto& v) { return v != first; })) {
      differences.push_back(std::move(difference));
    }
  }
  return differences;
}

Json ComparisonFigures(const std::vector<ComparedRun>& runs) {
  Json json = {{"columns", Json::array()}, {"runs", Json::array()}, {"differences", Json::array()}};
  for (const FigureColumn& column : FigureColumns()) {
    json["columns"].push_back({{"key", column.key}, {"heading", column.heading}});
  }
  for (const ComparedRun& run : runs) {
    const optim::StageReport* last = LastStage(run);
    Json one = {{"label", run.label},
                {"run_path", run.data.run_path},
                {"status", run.data.status},
                {"stage", last == nullptr ? "" : last->stage}};
    for (const FigureColumn& column : FigureColumns()) one[column.key] = ToJson(column.value(run));
    json["runs"].push_back(std::move(one));
  }
  for (const Difference& difference : DifferencesOf(runs)) {
    json["differences"].push_back({{"key", difference.key}, {"values", difference.values}});
  }
  return json;
}

std::string ComparisonTable(const std::vector<ComparedRun>& runs) {
  std::vector<std::vector<std::string>> rows = {{"Run", "Status"}};
  for (const FigureColumn& column : FigureColumns()) rows.front().emplace_back(column.heading);
  for (const ComparedRun& run : runs) {
    auto& row = rows.emplace_back(std::vector{WithoutControls(run.label), run.data.status});
    for (const FigureColumn& column : FigureColumns()) {
      const double value = column.value(run);
      row.push_back(std::isfinite(value) ? column.text(value) : "-");
    }
  }
  std::string text = AlignedTable(rows);
  const std::vector<Difference> differences = DifferencesOf(runs);
  if (differences.empty()) return text + "\nAll settings are the same.\n";
  rows = {{"Setting"}};
  for (const ComparedRun& run : runs) {
    rows.front().push_back(Shortened(WithoutControls(run.label)));
  }
  for (const Difference& difference : differences) {
    if (rows.size() > kMostDifferences) break;
    auto& row = rows.emplace_back(std::vector{WithoutControls(difference.key)});
    for (const std::string& value : difference.values) {
      row.push_back(Shortened(WithoutControls(value)));
    }
  }
  text += "\n" + AlignedTable(rows);
  if (differences.size() > kMostDifferences) {
    text += fmt::format("... and {} more\n", differences.size() - kMostDifferences);
  }
  return text;
}

Json ComparisonJson(const std::vector<ComparedRun>& runs, const ReportOptions& options) {
  Json json = ComparisonFigures(runs);
  json["figures"] = FiguresJson<optim::RoundReport>();
  for (std::size_t r = 0; r < runs.size(); ++r) {
    json["runs"][r]["history"] = ToJson(runs[r].data.history.rounds);
  }
  json["views"] = Json::array();
  json["views_note"] = "";
  std::size_t used = ReportPage(json).size();
  const std::vector<ComparedView> views = ViewsOf(runs);
  for (const ComparedView& view : views) {
    Json one = ViewJson(view, runs);
    used += JsonText(one, -1).size() + 1;
    if (json["views"].size() == kMostViews || used > options.max_bytes) break;
    json["views"].push_back(std::move(one));
  }
  json["views_note"] = fmt::format(
      "{} of {} views: held-out ones first, the worst first.", json["views"].size(), views.size());
  return json;
}

}  // namespace pathfit::app
