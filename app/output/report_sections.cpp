#include "app/output/report_sections.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/output/html_text.h"
#include "app/output/report_images.h"
#include "app/output/sha256.h"
#include "app/output/svg_plot.h"

namespace pathfit::app {
namespace {

constexpr std::size_t kMaxListedInputs = 300;
constexpr std::size_t kMaxConfigBytes = 200'000;

std::string Picture(const std::string& caption, const std::string& alt, const std::string& jpeg) {
  std::string html = "<figure>";
  if (jpeg.empty()) {
    html += "<div class=\"none\">not available</div>";
  } else {
    html += "<img alt=\"" + EscapeHtml(alt) + "\" src=\"" + DataUri("image/jpeg", jpeg) + "\">";
  }
  return html + "<figcaption>" + EscapeHtml(caption) + "</figcaption></figure>";
}

std::string List(const std::vector<std::string>& items) {
  std::string html = "<ul class=\"plain\">";
  for (const std::string& item : items) html += "<li>" + EscapeHtml(item) + "</li>";
  return html + "</ul>";
}

std::string BoundsText(const ParameterSummary& parameter) {
  if (std::isinf(parameter.lower) && std::isinf(parameter.upper)) return "none";
  return "[" + NumberText(parameter.lower) + ", " + NumberText(parameter.upper) + "]";
}

std::string ParameterRow(const ParameterSummary& parameter) {
  const bool group = parameter.num_scalars > 1;
  std::string state;
  if (parameter.hold) state = "<span class=\"tag\">held</span>";
  if (parameter.num_at_bound > 0 && !parameter.hold) {
    state += fmt::format("<span class=\"tag bound\">{}</span>",
                         group ? std::to_string(parameter.num_at_bound) + " at bound" : "at bound");
  }
  return fmt::format(
      "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
      "<td>{}</td><td>{}</td></tr>",
      EscapeHtml(parameter.name),
      EscapeHtml(parameter.unit),
      parameter.num_scalars,
      NumberText(parameter.initial),
      NumberText(parameter.final),
      group ? NumberText(parameter.minimum) + " … " + NumberText(parameter.maximum) : "",
      NumberText(parameter.rms_change),
      BoundsText(parameter),
      state);
}

std::string ConfigDetails(const std::string& title, const std::string& text) {
  if (text.empty()) return "";
  const bool cut = text.size() > kMaxConfigBytes;
  return "<details><summary>" + title + "</summary><pre>" +
         EscapeHtml(text.substr(0, kMaxConfigBytes)) + "</pre>" +
         (cut ? "<p class=\"note\">The rest is in the file of the run directory.</p>" : "") +
         "</details>";
}

std::string InputsDetails(const RunRecord& record) {
  if (record.inputs.empty()) return "";
  std::string html = fmt::format(
      "<details><summary>Input files and their SHA-256 ({})</summary><div "
      "class=\"scroll\"><table><thead><tr><th>File</th><th>Size</th><th "
      "class=\"left\">SHA-256</th></tr></thead><tbody>",
      record.inputs.size());
  for (std::size_t i = 0; i < std::min(record.inputs.size(), kMaxListedInputs); ++i) {
    const InputFile& input = record.inputs[i];
    html += "<tr><td class=\"wrap\">" + EscapeHtml(input.path) + "</td><td>" +
            BytesText(static_cast<double>(input.bytes)) + "</td><td class=\"left\"><code>" +
            EscapeHtml(input.sha256) + "</code></td></tr>";
  }
  html += "</tbody></table></div>";
  if (record.inputs.size() > kMaxListedInputs) {
    html += "<p class=\"note\">The others are in run.json.</p>";
  }
  return html + "</details>";
}

std::string Quoted(const std::vector<std::string>& argv) {
  std::string line;
  for (const std::string& word : argv) {
    const bool plain =
        !word.empty() && word.find_first_of(" \t\n\"'$`\\*?[]{}()<>|&;#~!") == std::string::npos;
    line += line.empty() ? "" : " ";
    if (plain) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += '\'';
  }
  return line;
}

}  // namespace

std::string DataUri(const std::string& mime, const std::string& bytes) {
  return "data:" + mime + ";base64," + Base64(bytes);
}

std::string ViewsIntroduction(const std::string& note) {
  return "<section id=\"views\"><h2>Views</h2><div class=\"card\"><p class=\"scale\">"
         "<span>Difference, rendered − photo, mean of the sRGB-encoded channels:</span><span>−" +
         fmt::format("{}</span><span class=\"ramp\"></span><span>+{}</span>",
                     kDifferenceScale,
                     kDifferenceScale) +
         "<span>(range 0…1; blue: too dark, red: too bright, grey: not compared)</span></p>"
         "<p class=\"scale\"><span>Silhouette:</span><span><i class=\"sw both\"></i>object in "
         "both<i class=\"sw fit\"></i>only rendered<i class=\"sw mask\"></i>only in the "
         "mask</span></p><p class=\"note\">" +
         EscapeHtml(note) + "</p></div>";
}

std::string ViewArticle(const ReportView& view, const std::string& result_name) {
  const std::string& name = view.last.name;
  std::string html = "<article class=\"card view\"><div class=\"head\"><h3>" + EscapeHtml(name) +
                     "</h3><span class=\"tag" + (view.last.validation ? " val" : "") + "\">" +
                     (view.last.validation ? "held out" : "fitted") +
                     "</span><span class=\"numbers\">";
  html +=
      "PSNR sRGB " + ChangeText(view.has_start, view.start.psnr_srgb, view.last.psnr_srgb, 2, "dB");
  html += " · linear " +
          ChangeText(view.has_start, view.start.psnr_linear, view.last.psnr_linear, 2, "dB");
  html += " · IoU " + ChangeText(view.has_start, view.start.iou, view.last.iou, 4, "");
  html += " · gain " + NumberText(view.last.gain) + "</span></div><div class=\"row\">";
  html += Picture("Photo", "photo " + name, view.photo);
  html += Picture("Start", "start, " + name, view.start_fit);
  html += Picture("After " + result_name, "result, " + name, view.result_fit);
  html += Picture("Difference", "difference, " + name, view.difference);
  return html + Picture("Silhouette", "silhouette, " + name, view.silhouette) + "</div></article>";
}

std::string ParametersSection(const FitHistory& history) {
  if (history.parameters.empty()) return "";
  std::string html =
      "<section id=\"parameters\"><h2>Parameters</h2><div class=\"card scroll\"><table><thead><tr>"
      "<th>Name</th><th>Unit</th><th>Scalars</th><th>Initial</th><th>Final</th><th>Range</th>"
      "<th>RMS change</th><th>Bounds</th><th></th></tr></thead><tbody>";
  for (const ParameterSummary& parameter : history.parameters) html += ParameterRow(parameter);
  return html +
         "</tbody></table><p class=\"note\">Groups of many scalars show their mean, range and root "
         "mean square change.</p></div></section>";
}

std::string ExposureSection(const FitHistory& history) {
  const optim::StageReport* last = LastReport(history);
  if (last == nullptr || last->views.empty()) return "";
  std::vector<BarGroup> groups;
  for (const optim::ViewReport& view : last->views) {
    const double ev = view.gain > 0.0 ? std::log2(view.gain) : 0.0;
    groups.push_back(
        {fmt::format("{}: gain {}, {} EV", view.name, NumberText(view.gain), FixedText(ev, 3, "")),
         {ev},
         view.validation ? 1 : 0});
  }
  PlotOptions options;
  options.title = "Gain of each photo";
  options.x_label = "photos in order";
  options.y_label = "EV (log2 gain)";
  return "<section id=\"exposure\"><h2>Exposure</h2>" + SvgBars(options, groups) +
         "<p class=\"note\"><i class=\"sw s0\"></i>fitted <i class=\"sw s1\"></i>held out. The "
         "gain multiplies the rendered radiance; numbers are in result/exposure.csv.</p></section>";
}

std::string EnvironmentSection(const ReportData& data) {
  if (data.environment_final.empty()) return "";
  const double exposure = data.history.environment_exposure;
  const auto picture = [](const char* caption, const std::string& png) {
    return png.empty() ? std::string()
                       : std::string("<figure><img alt=\"environment, ") + caption + "\" src=\"" +
                             DataUri("image/png", png) + "\"><figcaption>" + caption +
                             "</figcaption></figure>";
  };
  return "<section id=\"environment\"><h2>Environment light</h2><div class=\"card\"><div "
         "class=\"pair\">" +
         picture("Initial", data.environment_initial) + picture("Final", data.environment_final) +
         "</div><p class=\"note\">Latitude and longitude in the light's own frame, top is +y, the "
         "left edge and the right edge look along −z; values times " +
         NumberText(exposure) + " (" + FixedText(std::log2(exposure), 2, "EV") +
         "), the same for both, then the sRGB curve.</p></div></section>";
}

std::string AssumptionsSection(const RunRecord& record) {
  std::string html;
  if (!record.assumptions.empty()) {
    html += "<section id=\"assumptions\"><h2>Assumptions</h2><div class=\"card\">" +
            List(record.assumptions) + "</div></section>";
  }
  if (!record.attributions.empty()) {
    html += "<section id=\"attribution\"><h2>Attribution</h2><div class=\"card\">" +
            List(record.attributions) + "</div></section>";
  }
  return html;
}

std::string ReproductionSection(const ReportData& data) {
  const RunRecord& record = data.record;
  std::string html =
      "<section id=\"reproduction\"><h2>Reproduction</h2><div class=\"card\"><div "
      "class=\"scroll\"><table><tbody>";
  const auto row = [&html](const std::string& name, const std::string& value) {
    html += "<tr><td>" + name + "</td><td class=\"left wrap\">" + EscapeHtml(value) + "</td></tr>";
  };
  row("Program", "pathfit " + record.program_version + ", " + record.build);
  std::string libraries;
  for (const auto& [library, version] : record.libraries) {
    if (!libraries.empty()) libraries += ", ";
    libraries.append(library).append(" ").append(version);
  }
  row("Libraries", libraries);
  row("Machine",
      fmt::format("{}, {}, {} logical CPUs, {} threads used",
                  record.host,
                  record.cpu,
                  record.logical_cpus,
                  record.threads));
  row("Seed", std::to_string(record.seed));
  row("Configuration", record.config_path);
  for (const RunSession& session : record.sessions) {
    row(session.from_step == 0 ? "Command" : fmt::format("From step {}", session.from_step),
        Quoted(session.argv) + "  (" + session.started_utc +
            (session.outcome.empty() ? "" : ", " + session.outcome) + ")");
  }
  html += "</tbody></table></div>";
  html += ConfigDetails("config.yaml, as given", data.config);
  html += ConfigDetails("config.resolved.yaml, every value", data.resolved_config);
  return html + InputsDetails(record) + "</div></section>";
}

}  // namespace pathfit::app
