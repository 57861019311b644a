#pragma once

#include "app/output/evaluation.h"
#include "app/output/fields.h"

namespace pathfit::app {

// Names of the figures of an evaluation in JSON, and how its page calls them.

template <>
struct Fields<EvaluatedView> {
  static void Visit(auto& r, const auto& visit) {
    visit(Figure{.key = "view", .label = "View"}, r.view);
    visit(Figure{.key = "validation", .label = "Held out"}, r.validation);
    visit(Figure{.key = "psnr_srgb_db", .unit = "dB", .label = "PSNR sRGB"}, r.psnr_srgb);
    visit(Figure{.key = "psnr_linear_db", .unit = "dB", .label = "PSNR linear"}, r.psnr_linear);
    visit(Figure{.key = "psnr_scaled_db", .unit = "dB", .label = "PSNR sRGB, scaled"},
          r.psnr_scaled);
    visit(Figure{.key = "ssim", .label = "SSIM"}, r.ssim);
    visit(Figure{.key = "iou", .unit = "IoU", .label = "IoU"}, r.iou);
  }
};
template <>
struct Fields<EvaluatedSurface> {
  static void Visit(auto& r, const auto& visit) {
    visit(Figure{.key = "surface", .label = "Surface"}, r.surface);
    visit(Figure{.key = "diagonal_m", .unit = "m", .label = "Diagonal of the truth"}, r.diagonal);
    visit(Figure{.key = "mean_percent",
                 .unit = "%",
                 .label = "Distance",
                 .doc = "Mean of both ways over the diagonal."},
          r.mean_percent);
    visit(Figure{.key = "to_truth_mean_m", .unit = "m", .label = "To the truth, mean"},
          r.to_truth_mean);
    visit(Figure{.key = "to_truth_rms_m", .unit = "m", .label = "rms"}, r.to_truth_rms);
    visit(Figure{.key = "to_truth_most_m", .unit = "m", .label = "most"}, r.to_truth_most);
    visit(Figure{.key = "to_truth_angle_deg", .unit = "degrees", .label = "normals"},
          r.to_truth_angle_deg);
    visit(Figure{.key = "from_truth_mean_m", .unit = "m", .label = "From the truth, mean"},
          r.from_truth_mean);
    visit(Figure{.key = "from_truth_rms_m", .unit = "m", .label = "rms"}, r.from_truth_rms);
    visit(Figure{.key = "from_truth_most_m", .unit = "m", .label = "most"}, r.from_truth_most);
    visit(Figure{.key = "from_truth_angle_deg", .unit = "degrees", .label = "normals"},
          r.from_truth_angle_deg);
  }
};
template <>
struct Fields<EvaluatedAppearance> {
  static void Visit(auto& r, const auto& visit) {
    visit(Figure{.key = "property", .label = "Property"}, r.property);
    visit(Figure{.key = "surface", .label = "Surface"}, r.surface);
    visit(Figure{.key = "points", .label = "Points"}, r.points);
    visit(Figure{.key = "mean_truth", .label = "Mean of the truth"}, r.mean_truth);
    visit(Figure{.key = "rms", .label = "rms error"}, r.rms);
    visit(Figure{.key = "rms_percent", .unit = "%", .label = "rms error"}, r.rms_percent);
    visit(Figure{.key = "median", .label = "Median error"}, r.median);
    visit(Figure{.key = "scaled_percent", .unit = "%", .label = "scaled"}, r.scaled_percent);
  }
};
template <>
struct Fields<EvaluatedParameter> {
  static void Visit(auto& r, const auto& visit) {
    visit(Figure{.key = "name", .label = "Name"}, r.name);
    visit(Figure{.key = "unit", .label = "Unit"}, r.unit);
    visit(Figure{.key = "scalars", .label = "Numbers"}, r.scalars);
    visit(Figure{.key = "mean_error", .label = "Mean error"}, r.mean_error);
    visit(Figure{.key = "rms_error", .label = "rms error"}, r.rms_error);
    visit(Figure{.key = "largest_error", .label = "Largest error"}, r.largest_error);
    visit(Figure{.key = "rms_truth", .label = "rms of the truth"}, r.rms_truth);
  }
};
template <>
struct Fields<EvaluatedLight> {
  static void Visit(auto& r, const auto& visit) {
    visit(Figure{.key = "light", .label = "Light"}, r.light);
    visit(Figure{.key = "type", .label = "Type"}, r.type);
    visit(Figure{.key = "direction_deg", .unit = "degrees", .label = "Direction off"},
          r.direction_deg);
    visit(Figure{.key = "position_m", .unit = "m", .label = "Position off"}, r.position_m);
    visit(Figure{.key = "ratio_r", .label = "Ratio, red"}, r.ratio_r);
    visit(Figure{.key = "ratio_g", .label = "green"}, r.ratio_g);
    visit(Figure{.key = "ratio_b", .label = "blue"}, r.ratio_b);
    visit(Figure{.key = "radiance_percent",
                 .unit = "%",
                 .label = "Radiance, rms error",
                 .doc = "Over all directions, in percent of the truth's root mean square."},
          r.radiance_percent);
    visit(Figure{.key = "scaled_percent", .unit = "%", .label = "scaled"}, r.scaled_percent);
    visit(Figure{.key = "texels_percent",
                 .unit = "%",
                 .label = "Texels, rms error",
                 .doc = "Of the map's texels against the truth's mean over each, in percent of the "
                        "means' root mean square."},
          r.texels_percent);
    visit(Figure{.key = "texels_scaled_percent", .unit = "%", .label = "scaled"},
          r.texels_scaled_percent);
  }
};
template <>
struct Fields<EvaluatedCamera> {
  static void Visit(auto& r, const auto& visit) {
    visit(Figure{.key = "view", .label = "View"}, r.view);
    visit(Figure{.key = "validation", .label = "Held out"}, r.validation);
    visit(Figure{.key = "position_m", .unit = "m", .label = "Position off"}, r.position_m);
    visit(Figure{.key = "rotation_deg", .unit = "degrees", .label = "Rotation off"},
          r.rotation_deg);
    visit(Figure{.key = "focal_percent", .unit = "%", .label = "Focal length"}, r.focal_percent);
    visit(Figure{.key = "exposure_ev", .unit = "EV", .label = "Exposure"}, r.exposure_ev);
  }
};

}  // namespace pathfit::app
