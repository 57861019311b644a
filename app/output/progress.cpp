#include "app/output/progress.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/output/utc_time.h"

namespace pathfit::app {
namespace {

constexpr double kRedrawSeconds = 0.2;
constexpr double kLineSeconds = 10.0;
constexpr int kBarCells = 20;
constexpr double kRoundTimeMemory = 0.7;  ///< weight of the past in the running mean

double SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double RemainingSeconds(const optim::RoundReport& report, double seconds_per_round) {
  return std::max(report.max_rounds - report.round, 0) * seconds_per_round;
}

std::string Bar(const optim::RoundReport& report, bool utf8) {
  const double share = report.max_rounds > 0 ? double{1.0} * report.round / report.max_rounds : 0.0;
  const int filled = static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * kBarCells));
  std::string bar;
  for (int i = 0; i < kBarCells; ++i) {
    bar += i < filled ? (utf8 ? "█" : "#") : (utf8 ? "░" : "-");
  }
  return bar;
}

struct Part {
  std::string text;
  std::string_view sgr;
  int columns = 0;
};

Part TextPart(std::string text, std::string_view sgr) {
  // A multi-byte character takes one column; continuation bytes take none.
  const auto columns = std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U;
  });
  return {std::move(text), sgr, static_cast<int>(columns)};
}

nlohmann::ordered_json FiniteOrNull(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

std::string Dump(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string StageSentence(const optim::StageReport& report) {
  std::string text = WithoutControls(report.stage);
  if (report.rounds > 0) text += fmt::format(": {} rounds", report.rounds);
  if (std::isfinite(report.psnr_srgb_fit)) {
    text += fmt::format(", PSNR {:.2f} dB fitted", report.psnr_srgb_fit);
  }
  if (std::isfinite(report.psnr_srgb_val)) {
    text += fmt::format(", {:.2f} dB held out", report.psnr_srgb_val);
  }
  if (std::isfinite(report.iou_val)) text += fmt::format(", IoU {:.4f}", report.iou_val);
  text += fmt::format(", after {}", DurationText(report.wall_s));
  if (!report.stop_reason.empty()) {
    text += fmt::format(" ({})", WithoutControls(report.stop_reason));
  }
  return text;
}

std::string StagePlainLine(const optim::StageReport& report, const std::string& time) {
  std::string line = fmt::format("{} info stage={} end=true rounds={} wall_s={:.1f}",
                                 time,
                                 WithoutControls(report.stage),
                                 report.rounds,
                                 report.wall_s);
  if (std::isfinite(report.psnr_srgb_fit)) {
    line += fmt::format(" fit_psnr_srgb={:.2f}", report.psnr_srgb_fit);
  }
  if (std::isfinite(report.psnr_srgb_val)) {
    line += fmt::format(" val_psnr_srgb={:.2f}", report.psnr_srgb_val);
  }
  if (std::isfinite(report.iou_val)) line += fmt::format(" val_iou={:.4f}", report.iou_val);
  if (!report.kept.empty()) line += fmt::format(" kept={}", report.kept);
  if (!report.stop_reason.empty()) {
    line += fmt::format(" reason=\"{}\"", WithoutControls(report.stop_reason));
  }
  return line;
}

std::string StageJsonLine(const optim::StageReport& report, const std::string& time) {
  return Dump({{"time", time},
               {"level", "info"},
               {"stage", report.stage},
               {"end", true},
               {"rounds", report.rounds},
               {"wall_s", FiniteOrNull(report.wall_s)},
               {"fit_psnr_srgb", FiniteOrNull(report.psnr_srgb_fit)},
               {"val_psnr_srgb", FiniteOrNull(report.psnr_srgb_val)},
               {"val_iou", FiniteOrNull(report.iou_val)},
               {"kept", report.kept},
               {"reason", report.stop_reason}});
}

}  // namespace

std::string StatusLine(const optim::RoundReport& report,
                       double seconds_per_round,
                       int columns,
                       bool utf8,
                       bool color) {
  std::vector<Part> parts;
  parts.push_back(TextPart(
      fmt::format(
          "[{}/{} {}]", report.stage_index + 1, report.num_stages, WithoutControls(report.stage)),
      "1"));
  parts.push_back(TextPart(" " + Bar(report, utf8), "36"));
  parts.push_back(TextPart(fmt::format(" {}/{}", report.round, report.max_rounds), ""));
  if (std::isfinite(report.cost_total)) {
    parts.push_back(TextPart(fmt::format("  cost {:.3e}", report.cost_total), ""));
  }
  if (std::isfinite(report.cost_change_rel)) {
    parts.push_back(TextPart(fmt::format(" ({:+.1f} %)", 100.0 * report.cost_change_rel),
                             report.accepted ? "32" : "33"));
  }
  if (std::isfinite(report.psnr_linear_val)) {
    parts.push_back(TextPart(fmt::format("  val {:.1f} dB", report.psnr_linear_val), ""));
  }
  parts.push_back(TextPart(fmt::format("  {:.1f} s/it", seconds_per_round), "2"));
  parts.push_back(TextPart(
      fmt::format("  ETA {}", ClockText(RemainingSeconds(report, seconds_per_round))), "2"));

  int total = 0;
  for (const Part& part : parts) total += part.columns;
  // The last column stays free: some terminals wrap as soon as it is written.
  const int room = columns - 1;
  if (total > room) {
    total -= parts[1].columns;
    parts.erase(parts.begin() + 1);
  }
  while (total > room && parts.size() > 1) {
    total -= parts.back().columns;
    parts.pop_back();
  }
  if (total > room) return "";
  std::string line;
  for (const Part& part : parts) line += Colored(part.text, part.sgr, color);
  return line;
}

std::string PlainLine(const optim::RoundReport& report,
                      double seconds_per_round,
                      const std::string& time) {
  std::string line = fmt::format("{} info stage={} it={}/{}",
                                 time,
                                 WithoutControls(report.stage),
                                 report.round,
                                 report.max_rounds);
  if (std::isfinite(report.cost_total)) line += fmt::format(" cost={:.3e}", report.cost_total);
  if (std::isfinite(report.cost_change_rel)) {
    line += fmt::format(" dcost={:+.1f}%", 100.0 * report.cost_change_rel);
  }
  if (std::isfinite(report.psnr_linear_val)) {
    line += fmt::format(" val_psnr={:.1f}", report.psnr_linear_val);
  }
  return line + fmt::format(" s_per_it={:.1f} eta_s={:.0f}",
                            seconds_per_round,
                            RemainingSeconds(report, seconds_per_round));
}

std::string JsonLine(const optim::RoundReport& report,
                     double seconds_per_round,
                     const std::string& time) {
  return Dump({{"time", time},
               {"level", "info"},
               {"stage", report.stage},
               {"it", report.round},
               {"max_it", report.max_rounds},
               {"step", report.step},
               {"accepted", report.accepted},
               {"cost", FiniteOrNull(report.cost_total)},
               {"dcost_rel", FiniteOrNull(report.cost_change_rel)},
               {"val_psnr", FiniteOrNull(report.psnr_linear_val)},
               {"s_per_it", FiniteOrNull(seconds_per_round)},
               {"eta_s", FiniteOrNull(RemainingSeconds(report, seconds_per_round))}});
}

Progress::Progress(Terminal& terminal) : Progress(terminal, SteadySeconds) {}

Progress::Progress(Terminal& terminal, Clock clock)
    : terminal_(terminal), clock_(std::move(clock)) {}

double Progress::UpdateSecondsPerRound(const optim::RoundReport& report) {
  const double measured = any_round_ ? report.wall_s - last_wall_s_
                                     : report.render_s + report.jacobian_s + report.linear_s;
  last_wall_s_ = report.wall_s;
  const bool fresh = !any_round_ || report.stage != stage_;
  if (!std::isfinite(measured) || measured < 0.0) return seconds_per_round_;
  seconds_per_round_ =
      fresh ? measured
            : kRoundTimeMemory * seconds_per_round_ + (1.0 - kRoundTimeMemory) * measured;
  return seconds_per_round_;
}

void Progress::OnRound(const optim::RoundReport& report) {
  const double per_round = UpdateSecondsPerRound(report);
  const bool new_stage = !any_round_ || report.stage != stage_;
  any_round_ = true;
  stage_ = report.stage;
  const TerminalOptions& options = terminal_.options();
  const double now = clock_();
  const double interval = options.progress == ProgressMode::kBar ? kRedrawSeconds : kLineSeconds;
  if (!new_stage && now - last_output_s_ < interval) return;
  last_output_s_ = now;
  switch (options.progress) {
    case ProgressMode::kBar:
      terminal_.SetStatus(
          StatusLine(report, per_round, options.columns(), options.utf8, options.color));
      break;
    case ProgressMode::kPlain:
    case ProgressMode::kAuto:
      terminal_.PrintLine(PlainLine(report, per_round, UtcIsoNow()));
      break;
    case ProgressMode::kJson:
      terminal_.PrintLine(JsonLine(report, per_round, UtcIsoNow()));
      break;
    case ProgressMode::kNone:
      break;
  }
}

void Progress::OnStage(const optim::StageReport& report) {
  switch (terminal_.options().progress) {
    case ProgressMode::kBar:
      terminal_.ClearStatus();
      terminal_.PrintLine(StageSentence(report));
      break;
    case ProgressMode::kPlain:
    case ProgressMode::kAuto:
      terminal_.PrintLine(StagePlainLine(report, UtcIsoNow()));
      break;
    case ProgressMode::kJson:
      terminal_.PrintLine(StageJsonLine(report, UtcIsoNow()));
      break;
    case ProgressMode::kNone:
      break;
  }
  last_output_s_ = clock_();
}

void Progress::Finish() { terminal_.ClearStatus(); }

}  // namespace pathfit::app
