#include "app/output/metrics_csv.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <utility>

#include <fmt/format.h>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app {
namespace {

constexpr std::string_view kHeader =
    "step,stage,stage_index,round,max_rounds,wall_s,cost_total,cost_image,cost_silhouette,"
    "cost_priors,cost_change_rel,gradient_max,step_norm,trust_radius,accepted,spp,noise_rel,"
    "psnr_linear_fit_db,psnr_linear_val_db,iou_fit,iou_val,render_s,jacobian_s,linear_s,"
    "jacobian_mb,peak_rss_mb,linear_solver";

/// Step at the beginning of a row, -1 when there is none.
int StepOfRow(std::string_view row) {
  int step = -1;
  const auto [end, error] = std::from_chars(row.data(), row.data() + row.size(), step);
  const bool whole =
      error == std::errc() && end != row.data() + row.size() && *end == ',' && step >= 0;
  return whole ? step : -1;
}

}  // namespace

std::string CsvCell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string cell = "\"";
  for (const char c : text) {
    if (c == '"') cell += '"';
    cell += c;
  }
  return cell + "\"";
}

std::string CsvNumber(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : std::string();
}

std::string MetricsCsv::Header() { return std::string(kHeader); }

std::string MetricsCsv::Row(const optim::RoundReport& r) {
  // A stage name cannot break a row: the line break would split it for RemoveRowsAfter.
  std::string stage = r.stage;
  for (char& c : stage) c = c == '\n' || c == '\r' ? ' ' : c;
  std::string row =
      fmt::format("{},{},{},{},{}", r.step, CsvCell(stage), r.stage_index, r.round, r.max_rounds);
  const auto add = [&row](double value) { row += "," + CsvNumber(value); };
  add(r.wall_s);
  add(r.cost_total);
  add(r.cost_image);
  add(r.cost_silhouette);
  add(r.cost_priors);
  add(r.cost_change_rel);
  add(r.gradient_max);
  add(r.step_norm);
  add(r.trust_radius);
  row += fmt::format(",{},{}", r.accepted ? 1 : 0, r.spp);
  add(r.noise_relative);
  add(r.psnr_linear_fit);
  add(r.psnr_linear_val);
  add(r.iou_fit);
  add(r.iou_val);
  add(r.render_s);
  add(r.jacobian_s);
  add(r.linear_s);
  add(r.jacobian_mb);
  add(r.peak_rss_mb);
  return row + "," + CsvCell(r.linear_solver);
}

MetricsCsv::MetricsCsv(std::filesystem::path path, int last_step)
    : path_(std::move(path)), last_step_(last_step) {
  if (std::filesystem::exists(path_)) {
    RemoveRowsAfter(last_step);
  } else {
    renderer::WriteFileAtomically(path_, Header() + "\n");
  }
}

void MetricsCsv::RemoveRowsAfter(int step) {
  const std::string text = renderer::ReadWholeFile(path_);
  const std::string header = Header() + "\n";
  if (!text.starts_with(header)) {
    throw renderer::IoError(path_.string() + ":1: is not the metrics file of this version");
  }
  std::string kept = header;
  last_step_ = 0;
  for (std::size_t begin = header.size(); begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string::npos) break;  // torn by a kill while it was appended
    const std::string_view row = std::string_view(text).substr(begin, end - begin);
    const int row_step = StepOfRow(row);
    if (row_step < 0 || row_step > step) break;
    kept.append(row).append("\n");
    last_step_ = row_step;
    begin = end + 1;
  }
  if (kept != text) renderer::WriteFileAtomically(path_, kept);
}

void MetricsCsv::Append(const optim::RoundReport& report) {
  if (report.step <= last_step_) RemoveRowsAfter(report.step - 1);
  std::ofstream file(path_, std::ios::binary | std::ios::app);
  file << Row(report) << '\n';
  file.flush();
  if (!file) throw renderer::IoError(path_.string() + ": writing failed");
  last_step_ = report.step;
}

}  // namespace pathfit::app
