#pragma once

#include "app/output/fields.h"
#include "optim/round/fit_report.h"

namespace pathfit::app {

/// The figures of a round: metrics.csv, history.json, progress lines and the report's charts and
/// tables follow this list. A new one needs its line here and nothing else in this folder.
template <>
struct Fields<optim::RoundReport> {
  static void Visit(auto& r, const auto& visit) {
    constexpr const char* kCost = "Cost";
    constexpr const char* kPsnr = "PSNR inside the mask, linear values";
    constexpr const char* kIou = "Mask IoU";
    constexpr const char* kStep = "Step length";
    constexpr const char* kBoundaries = "Samples of boundaries per pixel";
    visit(Figure{.key = "step", .doc = "Rounds of all stages, counted from 1."}, r.step);
    visit(Figure{.key = "stage"}, r.stage);
    visit(Figure{.key = "stage_index"}, r.stage_index);
    visit(Figure{.key = "num_stages"}, r.num_stages);
    visit(Figure{.key = "round", .doc = "Within the stage, from 1."}, r.round);
    visit(Figure{.key = "max_rounds"}, r.max_rounds);
    visit(
        Figure{.key = "wall_s", .unit = "s", .doc = "Since the run began, resumed time included."},
        r.wall_s);
    visit(Figure{.key = "cost_total",
                 .label = "total",
                 .doc = "At the round's start, per valid pixel-channel.",
                 .chart = kCost,
                 .plain = " cost={:.3e}",
                 .status = "  cost {:.3e}"},
          r.cost_total);
    visit(Figure{.key = "cost_image", .label = "colours", .chart = kCost}, r.cost_image);
    visit(Figure{.key = "cost_silhouette", .label = "silhouettes", .chart = kCost},
          r.cost_silhouette);
    visit(Figure{.key = "cost_priors", .label = "priors", .chart = kCost}, r.cost_priors);
    visit(
        Figure{.key = "cost_change_rel",
               .doc = "(after - before) / before by the round's step, on its own samples: negative "
                      "when the cost falls, 0 when the step was rejected.",
               .plain = " dcost={:+.1f}%",
               .status = " ({:+.1f} %)",
               .scale = 100.0},
        r.cost_change_rel);
    visit(Figure{.key = "gradient_max"}, r.gradient_max);
    visit(Figure{.key = "step_norm", .label = "step", .chart = kStep}, r.step_norm);
    visit(Figure{.key = "trust_radius", .label = "trust radius", .chart = kStep}, r.trust_radius);
    visit(Figure{.key = "motion_px",
                 .unit = "px",
                 .label = "motion",
                 .doc = "By how much the step moved the mesh that moved most, in the images.",
                 .chart = "Motion in the images"},
          r.motion);
    visit(Figure{.key = "accepted"}, r.accepted);
    visit(Figure{.key = "image_scale", .doc = "Size of the photos in this round."}, r.image_scale);
    visit(Figure{.key = "spp",
                 .label = "Largest spp",
                 .doc = "Samples per pixel.",
                 .chart = "Samples per pixel",
                 .by_stage = "max"},
          r.samples.spp);
    visit(Figure{.key = "sppe", .label = "silhouettes, per pixel of length", .chart = kBoundaries},
          r.samples.sppe);
    visit(Figure{.key = "spp_direct", .label = "shadows", .chart = kBoundaries},
          r.samples.spp_direct);
    visit(Figure{.key = "spp_indirect", .label = "between surfaces", .chart = kBoundaries},
          r.samples.spp_indirect);
    visit(Figure{.key = "spp_pixel", .label = "pixel borders", .chart = kBoundaries},
          r.samples.spp_pixel);
    visit(Figure{.key = "noise_rel",
                 .doc = "RMS of the half difference of two renderings over RMS of the residual.",
                 .chart = "Sampling noise in the residual"},
          r.noise_relative);
    visit(Figure{.key = "psnr_linear_fit_db", .unit = "dB", .label = "fitted", .chart = kPsnr},
          r.psnr_linear_fit);
    visit(Figure{.key = "psnr_linear_val_db",
                 .unit = "dB",
                 .label = "held out",
                 .chart = kPsnr,
                 .plain = " val_psnr_linear={:.1f}",
                 .status = "  held out {:.1f} dB linear"},
          r.psnr_linear_val);
    visit(Figure{.key = "iou_fit", .unit = "IoU", .label = "fitted", .chart = kIou}, r.iou_fit);
    visit(Figure{.key = "iou_val", .unit = "IoU", .label = "held out", .chart = kIou}, r.iou_val);
    visit(Figure{.key = "moving_vertices",
                 .label = "Vertices",
                 .doc = "Vertices of the moving meshes, after the round.",
                 .chart = "Detail"},
          r.moving_vertices);
    visit(Figure{.key = "folded_edges",
                 .label = "Folded edges",
                 .doc = "Edges of the moving meshes folded over 150 degrees, after the round.",
                 .chart = "Folds"},
          r.folded_edges);
    visit(Figure{.key = "crossing_triangles",
                 .label = "Crossing triangles",
                 .doc = "Triangles of the moving meshes that pass through another one of their "
                        "part, after the round.",
                 .chart = "Folds"},
          r.crossing_triangles);
    visit(Figure{.key = "render_s", .unit = "s", .label = "Images", .by_stage = "sum"}, r.render_s);
    visit(Figure{.key = "jacobian_s", .unit = "s", .label = "Jacobian", .by_stage = "sum"},
          r.jacobian_s);
    visit(Figure{.key = "linear_s", .unit = "s", .label = "Linear solve", .by_stage = "sum"},
          r.linear_s);
    visit(Figure{.key = "jacobian_mb", .unit = "MB", .label = "Jacobian size", .by_stage = "max"},
          r.jacobian_mb);
    visit(Figure{.key = "peak_rss_mb", .unit = "MB", .label = "Peak memory", .by_stage = "max"},
          r.peak_rss_mb);
    visit(Figure{.key = "linear_solver", .label = "Linear solver", .by_stage = "last"},
          r.linear_solver);
    visit(Figure{.key = "solver_failure", .doc = "The solver's own words when it gave up."},
          r.solver_failure);
  }
};

template <>
struct Fields<optim::ViewReport> {
  static void Visit(auto& r, const auto& visit) {
    visit("name", r.name);
    visit("validation", r.validation);
    visit("psnr_linear_db", r.psnr_linear);
    visit("psnr_srgb_db", r.psnr_srgb);
    visit("iou", r.iou);
    visit("gain", r.gain);
  }
};

/// The figures of a stage, without its views: for run.json, progress lines and the report's table.
template <>
struct Fields<optim::StageReport> {
  static void Visit(auto& r, const auto& visit) {
    visit(Figure{.key = "stage", .label = "Stage"}, r.stage);
    visit(
        Figure{.key = "rounds", .label = "Rounds", .plain = " rounds={}", .status = ": {} rounds"},
        r.rounds);
    visit(Figure{.key = "wall_s",
                 .unit = "s",
                 .label = "Ended after",
                 .doc = "Since the run began, resumed time included.",
                 .plain = " wall_s={:.1f}"},
          r.wall_s);
    visit(Figure{.key = "cost_before",
                 .label = "Cost before",
                 .doc = "Same samples as for the cost after it."},
          r.cost_before);
    visit(Figure{.key = "cost_after", .label = "Cost after"}, r.cost_after);
    visit(Figure{.key = "psnr_srgb_fit_db",
                 .unit = "dB",
                 .label = "PSNR sRGB, fitted",
                 .plain = " fit_psnr_srgb={:.2f}",
                 .status = ", PSNR sRGB {:.2f} dB fitted"},
          r.psnr_srgb_fit);
    visit(Figure{.key = "psnr_srgb_val_db",
                 .unit = "dB",
                 .label = "PSNR sRGB, held out",
                 .plain = " val_psnr_srgb={:.2f}",
                 .status = ", {:.2f} dB held out"},
          r.psnr_srgb_val);
    visit(Figure{.key = "psnr_linear_fit_db", .unit = "dB", .label = "PSNR linear, fitted"},
          r.psnr_linear_fit);
    visit(Figure{.key = "psnr_linear_val_db", .unit = "dB", .label = "PSNR linear, held out"},
          r.psnr_linear_val);
    visit(Figure{.key = "iou_fit", .unit = "IoU", .label = "IoU, fitted"}, r.iou_fit);
    visit(Figure{.key = "iou_val",
                 .unit = "IoU",
                 .label = "IoU, held out",
                 .plain = " val_iou={:.4f}",
                 .status = ", IoU {:.4f}"},
          r.iou_val);
    visit(Figure{.key = "folded_edges",
                 .label = "Folded edges",
                 .doc = "Edges of the moving meshes folded over 150 degrees, after the stage."},
          r.folded_edges);
    visit(Figure{.key = "crossing_triangles",
                 .label = "Crossing triangles",
                 .doc = "Triangles of the moving meshes that pass through another one of their "
                        "part, after the stage."},
          r.crossing_triangles);
    visit(Figure{.key = "kept",
                 .label = "Kept",
                 .doc = "Which parameters the stage ended with: averaged, last or start.",
                 .plain = " kept={}"},
          r.kept);
    visit(Figure{.key = "stop_reason",
                 .label = "Ended because",
                 .plain = " reason=\"{}\"",
                 .status = " ({})"},
          r.stop_reason);
  }
};

/// The list itself, for the page: key, unit, label, doc, chart and by_stage of each figure.
template <class Report>
Json FiguresJson() {
  Json figures = Json::array();
  const Report none;
  Fields<Report>::Visit(none, [&figures](const Figure& f, const auto&) {
    figures.push_back({{"key", f.key},
                       {"unit", f.unit},
                       {"label", f.label},
                       {"doc", f.doc},
                       {"chart", f.chart},
                       {"by_stage", f.by_stage}});
  });
  return figures;
}

}  // namespace pathfit::app
