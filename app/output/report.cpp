#include "app/output/report.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "app/config/nearest_name.h"
#include "app/config/utf8.h"
#include "app/output/report_images.h"
#include "app/output/sha256.h"
#include "app/output/viewed_model.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxListedInputs = 300;
constexpr int kMaxFittedViews = 8;  // the worst ones; held-out views are all shown
constexpr std::size_t kMaxConfigBytes = 200'000;
constexpr double kModelShare = 0.5;  // of the page
// Limits of what deserves a warning.
constexpr double kOverfitDb = 2.0;
constexpr double kNoiseShare = 0.7;
constexpr double kVisibleLossDb = 0.05;
constexpr std::size_t kMostNames = 8;  // in one warning

std::string StatusSentence(const ReportData& data) {
  const std::string& reason = data.record.reason;
  const std::string why = reason.empty() ? "" : ": " + reason;
  if (data.status == "finished") return "The fit finished" + why + ".";
  if (data.status == "stopped") {
    return "The fit was stopped" + why +
           ". What is shown is the last stage that ended. It can be continued with: pathfit "
           "resume " +
           data.run_path;
  }
  if (data.status == "failed") {
    return "The fit failed" + why + ". What is shown is the last state that was kept.";
  }
  if (data.status == "killed") {
    return "The process ended without a word (killed, or the machine stopped). It can be "
           "continued with: pathfit resume " +
           data.run_path;
  }
  return "The fit was running when this report was written; it shows the stages that are done.";
}

std::string ReadIfThere(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) ? renderer::ReadWholeFile(path) : std::string();
}

const optim::StageReport* LastReport(const FitHistory& history) {
  return history.stages.empty() ? nullptr : &history.stages.back().report;
}

bool HasValidation(const optim::StageReport& report) {
  return std::ranges::any_of(report.views,
                             [](const optim::ViewReport& view) { return view.validation; });
}

Json PictureJson(const std::string& bytes, const char* mime) {
  return bytes.empty() ? Json(nullptr) : Json(DataUri(bytes, mime));
}

std::string Shortened(const std::string& text) {
  constexpr const char* kRest = "\n(The rest is in the file of the run directory.)";
  return text.size() <= kMaxConfigBytes ? text : FirstBytes(text, kMaxConfigBytes) + kRest;
}

std::string MegabytesText(std::size_t bytes) {
  return fmt::format("{:.1f} MB", 1e-6 * static_cast<double>(bytes));
}

/// Held-out views first, each kind from the worst to the best; only the worst of the fitted ones.
std::vector<std::size_t> ChosenViews(const std::vector<optim::ViewReport>& views) {
  std::vector<std::size_t> chosen(views.size());
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = i;
  std::ranges::stable_sort(chosen, [&](std::size_t a, std::size_t b) {
    if (views[a].validation != views[b].validation) return views[a].validation;
    const auto known = [&](std::size_t i) {  // NaN would be no order
      const double psnr = views[i].psnr_srgb;
      return std::isnan(psnr) ? std::numeric_limits<double>::infinity() : psnr;
    };
    return known(a) < known(b);
  });
  int num_fitted = 0;
  std::erase_if(chosen, [&](std::size_t i) {
    return !views[i].validation && ++num_fitted > kMaxFittedViews;
  });
  return chosen;
}

/// Adds as many of the chosen views as fit into a file that has `used` bytes without them.
void AddViews(const ReportData& data, const ReportOptions& options, std::size_t used, Json& json) {
  Json& shown = json["views"] = Json::array();
  json["views_note"] = "";
  const optim::StageReport* last = LastReport(data.history);
  if (last == nullptr) return;
  const std::vector<std::size_t> chosen = ChosenViews(last->views);
  constexpr std::size_t kNoteBytes = 1000;
  std::size_t total = used + kNoteBytes;
  std::size_t shown_held_out = 0;
  for (const std::size_t i : chosen) {
    Json pictures = Json::object();
    if (i < data.view_pictures.size()) {
      for (const auto& [kind, jpeg] : data.view_pictures[i]) {
        pictures[kind] = PictureJson(jpeg, "image/jpeg");
      }
    }
    const Json view = {{"index", i}, {"pictures", std::move(pictures)}};
    total += JsonText(view, -1).size() + 1;
    if (total > options.max_bytes) break;
    shown.push_back(view);
    shown_held_out += last->views[i].validation ? 1 : 0;
  }
  const auto num_held_out = static_cast<std::size_t>(std::ranges::count_if(
      last->views, [](const optim::ViewReport& view) { return view.validation; }));
  const std::size_t num_fitted = last->views.size() - num_held_out;
  const std::size_t shown_fitted = shown.size() - shown_held_out;
  std::string note = num_held_out > 0
                         ? fmt::format("{} of {} held-out views and ", shown_held_out, num_held_out)
                         : std::string();
  note += shown_fitted == num_fitted
              ? fmt::format("all {} fitted ones", num_fitted)
              : fmt::format("the {} worst of {} fitted ones", shown_fitted, num_fitted);
  note[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(note[0])));
  note += ", the worst first, by PSNR of the sRGB values.";
  if (shown.size() < chosen.size()) {
    note += fmt::format(" {} views were left out to keep this file below {}.",
                        chosen.size() - shown.size(),
                        MegabytesText(options.max_bytes));
  }
  json["views_note"] = note;
}

std::int64_t NumTriangles(const Json& model) {
  std::int64_t count = 0;
  for (const Json& mesh : model.at("meshes")) {
    count += mesh.value("num_triangles", std::int64_t{0});
  }
  return count;
}

/// Buffers that the start shares with the result are there once.
Json WithoutShared(Json start, const Json& result) {
  Json& meshes = start.at("meshes");
  for (std::size_t i = 0; i < meshes.size() && i < result.at("meshes").size(); ++i) {
    const Json& other = result.at("meshes")[i];
    for (const char* key :
         {"triangles", "uvs", "texture", "roughness_texture", "metallic_texture"}) {
      if (meshes[i].contains(key) && other.contains(key) && meshes[i][key] == other[key]) {
        meshes[i][key] = nullptr;
      }
    }
  }
  return start;
}

Json ModelJson(const ReportData& data, const ReportOptions& options) {
  if (data.model.is_null()) return nullptr;
  const double limit = kModelShare * static_cast<double>(options.max_bytes);
  double used = static_cast<double>(ThreeJs().size());
  Json json = {{"start", nullptr}, {"result", nullptr}, {"note", ""}};
  const auto add = [&](const char* key, const char* what, Json model) {
    const std::size_t size = JsonText(model, -1).size();
    if (used + static_cast<double>(size) > limit) {
      json["note"] = fmt::format(
          "{}{} is not shown: its {} triangles take {}, and this file stays below {}. Files of the "
          "meshes are in the run's folder result; `pathfit report RUN --max-size-mb {:.0f}` writes "
          "a page with all.",
          json["note"] == "" ? "" : json["note"].get<std::string>() + " ",
          what,
          NumTriangles(model),
          MegabytesText(size),
          MegabytesText(options.max_bytes),
          std::ceil(1e-6 * (used + static_cast<double>(size)) / kModelShare) + 1.0);
      return;
    }
    used += static_cast<double>(size);
    json[key] = std::move(model);
  };
  add("result", "The fitted shape", data.model);
  if (!json["result"].is_null() && !data.start_model.is_null()) {
    add("start", "The shape that the fit began with", WithoutShared(data.start_model, data.model));
  }
  return json;
}

/// JSON that can stand inside a script element: no < can end it, whatever follows.
std::string EmbeddedJson(const Json& json) {
  std::string text;
  for (const char c : JsonText(json, -1))
    text += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return text;
}

std::string Page(const Json& json, bool with_library, bool live) {
  std::string hashes = "'" + CspHash(ReportJs()) + "'";
  std::string library, follower;
  if (live) {
    hashes += " '" + CspHash(LiveJs()) + "'";
    follower.append("<script id=\"follower\">").append(LiveJs()).append("</script>");
  }
  if (with_library) {
    hashes += " '" + CspHash(ThreeJs()) + "'";
    library.append("<script id=\"three\">").append(ThreeJs()).append("</script>");
  }
  const std::map<std::string_view, std::string> parts = {
      {"style", std::string(ReportCss())},
      {"style-hash", CspHash(ReportCss())},
      {"script", std::string(ReportJs())},
      {"script-hashes", hashes},
      {"library", library},
      {"follower", follower},
      {"connect", live ? "connect-src 'self'; " : ""},
      {"data", EmbeddedJson(json)}};
  std::string page;
  std::string_view rest = ReportHtml();
  for (std::size_t at = rest.find("{{"); at != std::string_view::npos; at = rest.find("{{")) {
    const std::size_t end = rest.find("}}", at);
    page.append(rest.substr(0, at)).append(parts.at(rest.substr(at + 2, end - at - 2)));
    rest.remove_prefix(end + 2);
  }
  return page.append(rest);
}

/// Of single numbers that are not held and of which something is to be said: the first few, and how
/// many more.
std::string NamesOfSingle(const std::vector<ParameterSummary>& parameters,
                          std::int64_t ParameterSummary::*number) {
  std::vector<std::string> names;
  for (const ParameterSummary& parameter : parameters) {
    if (parameter.*number == 0 || parameter.num_scalars != 1 || parameter.held) continue;
    names.push_back(parameter.name);
  }
  if (names.size() <= kMostNames) return JoinNames(names);
  const std::size_t more = names.size() - kMostNames;
  names.resize(kMostNames);
  return fmt::format("{} and {} more", JoinNames(names), more);
}

}  // namespace

fs::path ThumbnailPath(const RunDirectory& run,
                       const std::string& view_folder,
                       const std::string& kind) {
  return run.Images() / view_folder / ("thumbnail_" + kind + ".jpg");
}

ReportData LoadReportData(const RunDirectory& run) {
  ReportData data;
  data.run_path = run.root().string();
  data.record = ReadRunRecord(run.Record());
  data.status = EffectiveStatus(data.record, run.root());
  if (fs::exists(run.History())) data.history = ReadHistory(run.History());
  data.config = ReadIfThere(run.Config());
  data.resolved_config = ReadIfThere(run.ResolvedConfig());
  if (const optim::StageReport* last = LastReport(data.history)) {
    std::vector<std::string> names;
    for (const optim::ViewReport& view : last->views) names.push_back(view.name);
    for (const std::string& folder : ViewFolderNames(names)) {
      auto& pictures = data.view_pictures.emplace_back();
      for (const char* kind : kViewPictures) {
        std::string jpeg = ReadIfThere(ThumbnailPath(run, folder, kind));
        if (!jpeg.empty()) pictures[kind] = std::move(jpeg);
      }
    }
  }
  data.start_model = ReadViewedModel(run.StartModel());
  data.model = ReadViewedModel(run.Model());
  data.environment_initial = ReadIfThere(run.Images() / "environment_initial.png");
  data.environment_final = ReadIfThere(run.Images() / "environment_final.png");
  return data;
}

std::vector<std::string> DerivedWarnings(const FitHistory& history) {
  std::vector<std::string> warnings;
  const optim::StageReport* last = LastReport(history);
  if (last != nullptr && HasValidation(*last)) {
    if (last->psnr_srgb_val < last->psnr_srgb_fit - kOverfitDb) {
      warnings.push_back(
          fmt::format("Held-out views are {:.1f} dB worse than fitted ones: the result does not "
                      "generalise to views it was not fitted to.",
                      last->psnr_srgb_fit - last->psnr_srgb_val));
    }
    for (std::size_t i = 1; i < history.stages.size(); ++i) {
      const double lost =
          history.stages[i - 1].report.psnr_srgb_val - history.stages[i].report.psnr_srgb_val;
      // One that kept what it began with changed nothing but the samples.
      if (lost > kVisibleLossDb && history.stages[i].report.kept != "start") {
        warnings.push_back(fmt::format("Stage {} made the held-out views {:.2f} dB worse.",
                                       history.stages[i].report.stage,
                                       lost));
      }
    }
  }
  if (last != nullptr && !HasValidation(*last)) {
    warnings.emplace_back("No view was held out, so nothing says how the result generalises.");
  }
  const auto add_names = [&](const char* what, std::int64_t ParameterSummary::*number) {
    const std::string names = NamesOfSingle(history.parameters, number);
    if (!names.empty()) warnings.push_back(what + names + ".");
  };
  add_names("Ended at a bound: ", &ParameterSummary::num_at_bound);
  add_names("Not determined by the photos, or hidden by the renderings' noise: ",
            &ParameterSummary::num_undetermined);
  if (!history.rounds.empty() && history.rounds.back().noise_relative > kNoiseShare) {
    warnings.push_back(fmt::format("In the last round {:.0f} % of the residual was sampling noise.",
                                   100.0 * history.rounds.back().noise_relative));
  }
  return warnings;
}

Json ReportJson(const ReportData& data, const ReportOptions& options) {
  std::vector<std::string> warnings = data.record.warnings;
  for (std::string& warning : DerivedWarnings(data.history)) warnings.push_back(std::move(warning));
  Json run = ToJson(data.record);
  Json::array_t& inputs = run["inputs"].get_ref<Json::array_t&>();
  inputs.resize(std::min(inputs.size(), kMaxListedInputs));
  Json json = {{"run_path", data.run_path},
               {"status", data.status},
               {"sentence", StatusSentence(data)},
               {"warnings", std::move(warnings)},
               {"run", std::move(run)},
               {"num_inputs", data.record.inputs.size()},
               {"seed", std::to_string(data.record.seed)},  // a number of a script has 53 bits
               {"history", ToJson(data.history)},
               {"figures",
                {{"round", FiguresJson<optim::RoundReport>()},
                 {"stage", FiguresJson<optim::StageReport>()}}},
               {"difference_scale", kDifferenceScale},
               {"environment",
                {{"initial", PictureJson(data.environment_initial, "image/png")},
                 {"final", PictureJson(data.environment_final, "image/png")}}},
               {"config", Shortened(data.config)},
               {"resolved_config", Shortened(data.resolved_config)}};
  json["model"] = ModelJson(data, options);
  AddViews(data, options, ReportPage(json).size(), json);
  return json;
}

std::string ReportPage(const Json& json) {
  const bool has_model =
      json.contains("model") && json["model"].is_object() && !json["model"].at("result").is_null();
  return Page(json, has_model, false);
}

std::string LivePage(const Json& json) { return Page(json, true, true); }

void WriteReport(const RunDirectory& run, const ReportOptions& options) {
  renderer::WriteFileAtomically(run.Report(), ReportPage(ReportJson(LoadReportData(run), options)));
}

}  // namespace pathfit::app
