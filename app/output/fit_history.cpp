#include "app/output/fit_history.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kHistoryVersion = 1;

/// JSON has no infinities; the names below read back, NaN becomes null.
Json NumberJson(double value) {
  if (std::isnan(value)) return nullptr;
  if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
  return value;
}

double NumberFrom(const Json& json) {
  if (json.is_number()) return json.get<double>();
  if (json == "inf") return std::numeric_limits<double>::infinity();
  if (json == "-inf") return -std::numeric_limits<double>::infinity();
  return std::numeric_limits<double>::quiet_NaN();
}

/// Calls visit(key, field) for every field of a struct, so that writing and reading cannot differ.
template <class Report, class Visit>
void VisitRound(Report& r, const Visit& visit) {
  visit("step", r.step);
  visit("stage", r.stage);
  visit("stage_index", r.stage_index);
  visit("num_stages", r.num_stages);
  visit("round", r.round);
  visit("max_rounds", r.max_rounds);
  visit("wall_s", r.wall_s);
  visit("cost_total", r.cost_total);
  visit("cost_image", r.cost_image);
  visit("cost_silhouette", r.cost_silhouette);
  visit("cost_priors", r.cost_priors);
  visit("cost_change_rel", r.cost_change_rel);
  visit("gradient_max", r.gradient_max);
  visit("step_norm", r.step_norm);
  visit("trust_radius", r.trust_radius);
  visit("accepted", r.accepted);
  visit("spp", r.spp);
  visit("noise_rel", r.noise_relative);
  visit("psnr_linear_fit_db", r.psnr_linear_fit);
  visit("psnr_linear_val_db", r.psnr_linear_val);
  visit("iou_fit", r.iou_fit);
  visit("iou_val", r.iou_val);
  visit("render_s", r.render_s);
  visit("jacobian_s", r.jacobian_s);
  visit("linear_s", r.linear_s);
  visit("jacobian_mb", r.jacobian_mb);
  visit("peak_rss_mb", r.peak_rss_mb);
  visit("linear_solver", r.linear_solver);
}

template <class Report, class Visit>
void VisitView(Report& r, const Visit& visit) {
  visit("name", r.name);
  visit("validation", r.validation);
  visit("psnr_linear_db", r.psnr_linear);
  visit("psnr_srgb_db", r.psnr_srgb);
  visit("iou", r.iou);
  visit("gain", r.gain);
}

template <class Report, class Visit>
void VisitStage(Report& r, const Visit& visit) {
  visit("stage", r.stage);
  visit("wall_s", r.wall_s);
  visit("rounds", r.rounds);
  visit("cost_before", r.cost_before);
  visit("cost_after", r.cost_after);
  visit("kept", r.kept);
  visit("psnr_srgb_fit_db", r.psnr_srgb_fit);
  visit("psnr_srgb_val_db", r.psnr_srgb_val);
  visit("psnr_linear_fit_db", r.psnr_linear_fit);
  visit("psnr_linear_val_db", r.psnr_linear_val);
  visit("iou_fit", r.iou_fit);
  visit("iou_val", r.iou_val);
  visit("stop_reason", r.stop_reason);
}

template <class Summary, class Visit>
void VisitParameter(Summary& p, const Visit& visit) {
  visit("name", p.name);
  visit("unit", p.unit);
  visit("num_scalars", p.num_scalars);
  visit("initial", p.initial);
  visit("final", p.final);
  visit("minimum", p.minimum);
  visit("maximum", p.maximum);
  visit("rms_change", p.rms_change);
  visit("lower", p.lower);
  visit("upper", p.upper);
  visit("num_at_bound", p.num_at_bound);
  visit("hold", p.hold);
}

auto Writer(Json& json) {
  return [&json]<class T>(const char* key, const T& value) {
    if constexpr (std::is_same_v<T, double>) {
      json[key] = NumberJson(value);
    } else {
      json[key] = value;
    }
  };
}

auto Reader(const Json& json) {
  return [&json]<class T>(const char* key, T& value) {
    if constexpr (std::is_same_v<T, double>) {
      value = NumberFrom(json.at(key));
    } else {
      json.at(key).get_to(value);
    }
  };
}

Json ToJson(const FitHistory& history) {
  Json rounds = Json::array();
  for (const optim::RoundReport& round : history.rounds) {
    VisitRound(round, Writer(rounds.emplace_back()));
  }
  Json stages = Json::array();
  for (const StageEntry& entry : history.stages) {
    Json& stage = stages.emplace_back();
    stage["after_step"] = entry.after_step;
    VisitStage(entry.report, Writer(stage));
    Json& views = stage["views"] = Json::array();
    for (const optim::ViewReport& view : entry.report.views) {
      VisitView(view, Writer(views.emplace_back()));
    }
  }
  Json parameters = Json::array();
  for (const ParameterSummary& parameter : history.parameters) {
    VisitParameter(parameter, Writer(parameters.emplace_back()));
  }
  return {{"version", kHistoryVersion},
          {"environment_exposure", NumberJson(history.environment_exposure)},
          {"rounds", std::move(rounds)},
          {"stages", std::move(stages)},
          {"parameters", std::move(parameters)}};
}

FitHistory FromJson(const Json& json) {
  FitHistory history;
  history.environment_exposure = NumberFrom(json.at("environment_exposure"));
  for (const Json& round : json.at("rounds")) {
    VisitRound(history.rounds.emplace_back(), Reader(round));
  }
  for (const Json& stage : json.at("stages")) {
    StageEntry& entry = history.stages.emplace_back();
    stage.at("after_step").get_to(entry.after_step);
    VisitStage(entry.report, Reader(stage));
    for (const Json& view : stage.at("views")) {
      VisitView(entry.report.views.emplace_back(), Reader(view));
    }
  }
  for (const Json& parameter : json.at("parameters")) {
    VisitParameter(history.parameters.emplace_back(), Reader(parameter));
  }
  return history;
}

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
  renderer::WriteFileAtomically(
      path, ToJson(history).dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

FitHistory ReadHistory(const std::filesystem::path& path) {
  const std::string text = renderer::ReadWholeFile(path);
  try {
    const Json json = Json::parse(text);
    if (json.at("version") != kHistoryVersion) {
      throw renderer::IoError(path.string() + ": was written by another version of the program");
    }
    return FromJson(json);
  } catch (const Json::exception& error) {
    throw renderer::IoError(path.string() + ": is not a run's history: " + error.what());
  }
}

}  // namespace pathfit::app
