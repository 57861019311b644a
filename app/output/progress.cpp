#include "app/output/progress.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/config/utf8.h"
#include "app/output/figures.h"
#include "app/output/log.h"

namespace pathfit::app {
namespace {

// Good fits end above 22 dB, such with a wrong light or without masks at 14 to 17.
constexpr double kHardlyExplainedDb = 18.0;
constexpr double kFarWorseDb = 6.0, kFarWorseIou = 0.9;  // held-out photos, of fitted ones

constexpr double kRedrawSeconds = 0.2;
constexpr double kLineSeconds = 10.0;
constexpr int kBarCells = 20;
constexpr int kShortBarCells = 8;  // where there is little room
constexpr double kLongestSeconds = 1e9;
constexpr double kRoundTimeMemory = 0.7;  ///< weight of the past in the running mean

double SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string Bar(const optim::RoundReport& report, int cells, bool utf8) {
  const double share = report.max_rounds > 0 ? double{1.0} * report.round / report.max_rounds : 0.0;
  const int filled = static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * cells));
  std::string bar;
  for (int i = 0; i < cells; ++i) bar += i < filled ? (utf8 ? "█" : "#") : (utf8 ? "░" : "-");
  return bar;
}

struct Part {
  std::string text;
  std::string_view sgr;
  int columns = 0;
};

Part TextPart(std::string text, std::string_view sgr) {
  const int columns = static_cast<int>(NumCharacters(text));
  return {std::move(text), sgr, columns};
}

/// Parts of a line for the figures that have such a pattern; numbers that are not finite and empty
/// texts are left out.
template <class Report>
std::vector<std::string> FigureTexts(const Report& report, const char* Figure::*pattern) {
  std::vector<std::string> texts;
  Fields<Report>::Visit(report, [&]<class T>(const Figure& figure, const T& value) {
    const std::string_view text = figure.*pattern;
    if (text.empty()) return;
    if constexpr (std::is_same_v<T, std::string>) {
      if (!value.empty()) texts.push_back(fmt::format(fmt::runtime(text), WithoutControls(value)));
    } else if constexpr (std::is_same_v<T, double>) {
      if (std::isfinite(value))
        texts.push_back(fmt::format(fmt::runtime(text), figure.scale * value));
    } else {
      texts.push_back(fmt::format(fmt::runtime(text), value));
    }
  });
  return texts;
}

template <class Report>
std::string FigureText(const Report& report, const char* Figure::*pattern) {
  std::string line;
  for (const std::string& text : FigureTexts(report, pattern)) line += text;
  return line;
}

/// One JSON object with all figures.
template <class Report>
Json FigureLine(const Report& report, const std::string& time) {
  Json line = {{"time", time}, {"level", "info"}};
  line.update(ToJson(report));
  return line;
}

std::string StageSentence(const optim::StageReport& report) {
  return WithoutControls(report.stage) + FigureText(report, &Figure::status) + ", after " +
         DurationText(report.wall_s);
}

std::string StageJsonLine(const optim::StageReport& report, const std::string& time) {
  Json line = FigureLine(report, time);
  line["end"] = true;
  return JsonText(line, -1);
}

}  // namespace

std::string ClockText(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  const long total = std::lround(std::clamp(seconds, 0.0, kLongestSeconds));
  if (total >= 3600) {
    return fmt::format("{}:{:02}:{:02}", total / 3600, total / 60 % 60, total % 60);
  }
  return fmt::format("{}:{:02}", total / 60, total % 60);
}

std::string DurationText(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  const double s = std::clamp(seconds, 0.0, kLongestSeconds);
  if (s < 99.95) return fmt::format("{:.1f} s", s);
  const long total = std::lround(s);
  if (total < 3600) return fmt::format("{} min {:02} s", total / 60, total % 60);
  return fmt::format("{} h {:02} min", total / 3600, total / 60 % 60);
}

std::string StatusLine(const optim::RoundReport& report,
                       double seconds_per_round,
                       double eta_s,
                       int columns,
                       bool utf8,
                       bool color) {
  const auto part = [](std::string text, std::string_view sgr) {
    return TextPart(std::move(text), sgr);
  };
  const auto bar = [&](int cells) { return part(" " + Bar(report, cells, utf8), "36"); };
  std::vector<Part> figures;
  for (std::string& text : FigureTexts(report, &Figure::status)) {
    figures.push_back(part(std::move(text), ""));
  }
  std::vector<Part> parts;
  parts.push_back(part(
      fmt::format(
          "[{}/{} {}]", report.stage_index + 1, report.num_stages, WithoutControls(report.stage)),
      "1"));
  parts.push_back(bar(kBarCells));
  parts.push_back(
      part(fmt::format(" {}/{}", report.round, report.max_rounds), report.accepted ? "32" : "33"));
  const std::size_t first_figure = parts.size();
  std::ranges::copy(figures, std::back_inserter(parts));
  parts.push_back(part(fmt::format("  {:.1f} s/it", seconds_per_round), "2"));
  parts.push_back(part(fmt::format("  ETA {}", ClockText(eta_s)), "2"));

  // The last column stays free: some terminals wrap as soon as it is written.
  const int room = columns - 1;
  const auto too_long = [&] {
    int total = 0;
    for (const Part& one : parts) total += one.columns;
    return total > room;
  };
  const auto leave_out = [&](std::size_t i) {
    parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(i));
  };
  if (too_long()) leave_out(parts.size() - 2);
  if (too_long()) parts[1] = bar(kShortBarCells);
  // Of the figures the last one, what held-out photos say, stays longest.
  for (std::size_t left = figures.size(); left > 0 && too_long(); --left) {
    leave_out(first_figure + (left > 1 ? left - 2 : 0));
  }
  if (too_long()) leave_out(1);
  while (too_long() && parts.size() > 1) parts.pop_back();
  if (too_long()) return "";
  std::string line;
  for (const Part& one : parts) line += Colored(one.text, one.sgr, color);
  return line;
}

std::string PlainLine(const optim::RoundReport& report,
                      double seconds_per_round,
                      double eta_s,
                      const std::string& time) {
  return fmt::format("{} info {} s_per_it={:.1f} eta_s={:.0f}",
                     time,
                     RoundWords(report),
                     seconds_per_round,
                     eta_s);
}

std::string RoundWords(const optim::RoundReport& report) {
  return fmt::format(
             "stage={} it={}/{}", WithoutControls(report.stage), report.round, report.max_rounds) +
         FigureText(report, &Figure::plain);
}

std::string StageWords(const optim::StageReport& report) {
  return "stage=" + WithoutControls(report.stage) + " end=true" +
         FigureText(report, &Figure::plain);
}

std::string ResultWords(const FitHistory& history) {
  if (history.stages.size() < 2) return "";
  const optim::StageReport& first = history.stages.front().report;
  const optim::StageReport& last = history.stages.back().report;
  std::string words;
  const auto add = [&](const char* pattern, double from, double to) {
    if (!std::isfinite(from) || !std::isfinite(to)) return false;
    words += (words.empty() ? "" : ", ") + fmt::format(fmt::runtime(pattern), from, to);
    return true;
  };
  if (!add("PSNR of held-out photos {:.1f} -> {:.1f} dB (sRGB)",
           first.psnr_srgb_val,
           last.psnr_srgb_val)) {
    add("PSNR of the photos {:.1f} -> {:.1f} dB (sRGB)", first.psnr_srgb_fit, last.psnr_srgb_fit);
  }
  if (!add("mask IoU {:.3f} -> {:.3f}", first.iou_val, last.iou_val)) {
    add("mask IoU {:.3f} -> {:.3f}", first.iou_fit, last.iou_fit);
  }
  return words;
}

std::string DoubtWords(const FitHistory& history) {
  if (history.stages.size() < 2) return "";
  const optim::StageReport& last = history.stages.back().report;
  const bool held_out = std::isfinite(last.psnr_srgb_val);
  const double psnr = held_out ? last.psnr_srgb_val : last.psnr_srgb_fit;
  if (psnr < kHardlyExplainedDb) {
    return fmt::format(
        "the result explains hardly anything of {} ({:.1f} dB): the worst pictures in the report "
        "show where. Wrong cameras or masks, photos that are turned (orientation: exif or sensor), "
        "no masks at all, and a light of the wrong kind (frame: world or camera, or a flash) do "
        "that, and so do things that moved between the "
        "photos, or a start too far off (other values, another --seed)",
        held_out ? "the held-out photos" : "the photos",
        psnr);
  }
  const bool is_far_worse = last.psnr_srgb_val < last.psnr_srgb_fit - kFarWorseDb ||
                            last.iou_val < kFarWorseIou * last.iou_fit;
  if (!is_far_worse) return "";
  const auto iou = [](double value) {
    return std::isfinite(value) ? fmt::format(", IoU {:.2f}", value) : "";
  };
  return fmt::format(
      "held-out photos are explained far worse ({:.1f} dB{}) than fitted ones ({:.1f} dB{}): what "
      "these leave open is wrong in the result. Too few photos, or from too few sides, do that, "
      "and so does a material, or a light, of the wrong kind",
      last.psnr_srgb_val,
      iou(last.iou_val),
      last.psnr_srgb_fit,
      iou(last.iou_fit));
}

std::string JsonLine(const optim::RoundReport& report,
                     double seconds_per_round,
                     double eta_s,
                     const std::string& time) {
  Json line = FigureLine(report, time);
  line["s_per_it"] = ToJson(seconds_per_round);
  line["eta_s"] = ToJson(eta_s);
  return JsonText(line, -1);
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
  remaining_.OnRound(report);
  const bool new_stage = !any_round_ || report.stage != stage_;
  any_round_ = true;
  stage_ = report.stage;
  const TerminalOptions& options = terminal_.options();
  const double now = clock_();
  const double interval = options.progress == ProgressMode::kBar ? kRedrawSeconds : kLineSeconds;
  if (!new_stage && now - last_output_s_ < interval) return;
  last_output_s_ = now;
  if (options.progress == ProgressMode::kBar) {
    terminal_.SetStatus(StatusLine(
        report, per_round, remaining_.Seconds(), options.columns(), options.utf8, options.color));
  } else if (options.progress == ProgressMode::kJson) {
    terminal_.PrintLine(JsonLine(report, per_round, remaining_.Seconds(), UtcIsoNow()));
  } else if (options.progress != ProgressMode::kNone) {
    terminal_.PrintLine(PlainLine(report, per_round, remaining_.Seconds(), UtcIsoNow()));
  }
}

void Progress::OnStage(const optim::StageReport& report) {
  remaining_.OnStage(report);
  const ProgressMode mode = terminal_.options().progress;
  if (mode == ProgressMode::kBar) {
    terminal_.ClearStatus();
    terminal_.PrintLine(StageSentence(report));
  } else if (mode == ProgressMode::kJson) {
    terminal_.PrintLine(StageJsonLine(report, UtcIsoNow()));
  } else if (mode != ProgressMode::kNone) {
    terminal_.PrintLine(UtcIsoNow() + " info " + StageWords(report));
  }
  last_output_s_ = clock_();
}

void Progress::Finish() { terminal_.ClearStatus(); }

}  // namespace pathfit::app
