#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/output/fields.h"
#include "renderer/core/parallel.h"
#include "renderer/emitter/emitter.h"
#include "renderer/scene/scene.h"

namespace pathfit::app {

/// What cannot be told is NaN, null in JSON.

/// A picture against a photo, or against the same view of the truth.
struct EvaluatedView {
  std::string view;
  bool validation = false;
  double psnr_srgb = 0.0, psnr_linear = 0.0, ssim = 0.0, iou = 0.0;
  double psnr_scaled = 0.0;  ///< of a relit view, after the one factor per channel of all views
};

/// Surfaces of the run against those of the truth, metres; `from_truth`: of points of the truth to
/// the run's surface.
struct EvaluatedSurface {
  std::string surface;  ///< name of a mesh, or "all", or "seen": all that a fitted photo sees
  double diagonal = 0.0, mean_percent = 0.0;
  double to_truth_mean = 0.0, to_truth_rms = 0.0, to_truth_most = 0.0, to_truth_angle_deg = 0.0;
  double from_truth_mean = 0.0, from_truth_rms = 0.0, from_truth_most = 0.0,
         from_truth_angle_deg = 0.0;
};

/// A property of materials at points of the truth and the run's points next to them.
struct EvaluatedAppearance {
  std::string property, surface;  ///< "base_color", "roughness", "metallic"; "all" or "seen"
  int points = 0;
  double mean_truth = 0.0, rms = 0.0, rms_percent = 0.0;
  double median = 0.0;          ///< of the points' errors, which those along edges do not move
  double scaled_percent = 0.0;  ///< after one factor per channel, which light and colours share
};

struct EvaluatedParameter {
  std::string name, unit;
  int scalars = 0;
  double mean_error = 0.0, rms_error = 0.0, largest_error = 0.0, rms_truth = 0.0;
};

struct EvaluatedLight {
  std::string light, type;
  double direction_deg = 0.0, position_m = 0.0;
  double ratio_r = 0.0, ratio_g = 0.0, ratio_b = 0.0;   ///< intensity of the run over the truth's
  double radiance_percent = 0.0, scaled_percent = 0.0;  ///< rms over all directions
  /// The same of the run's texels against the means of the truth over them: 0 for the best map of
  /// so many texels.
  double texels_percent = 0.0, texels_scaled_percent = 0.0;
};

struct EvaluatedCamera {
  std::string view;
  bool validation = false;
  double position_m = 0.0, rotation_deg = 0.0, focal_percent = 0.0, exposure_ev = 0.0;
};

/// A view with its pictures as JPEG bytes.
struct EvaluatedPicture {
  std::string title, tag;
  std::vector<std::pair<std::string, std::string>> pictures;  ///< caption, bytes
};

struct Evaluation {
  double image_scale = 1.0;
  std::vector<EvaluatedView> views;
  std::string relit_by;
  std::vector<EvaluatedView> relit;
  std::vector<EvaluatedSurface> surfaces;
  std::vector<EvaluatedAppearance> appearance;
  std::vector<EvaluatedParameter> parameters;
  std::vector<EvaluatedLight> lights;
  std::vector<EvaluatedCamera> cameras;
  std::vector<std::string> notes;
  std::vector<EvaluatedPicture> pictures;
};

struct EvaluationOptions {
  int spp = 64;
  int points = 50000;  ///< of each surface
  /// Light of the relit pictures; absent: a grey sky and a sun.
  std::optional<renderer::EnvironmentEmitter> environment;
  std::string environment_name;
  const renderer::CancelFlag* cancel = nullptr;
};

/// `run`: with the scene that was found. The photos of a run against its scene; with a truth also
/// pictures under another light, surfaces, materials, unknowns, lights and cameras.
Evaluation Evaluate(const Experiment& run,
                    const renderer::Scene* truth,
                    const EvaluationOptions& options);

/// The figures: {schema: "pathfit-eval-1", ...}; README.md lists them.
Json EvaluationJson(const Evaluation& evaluation);
/// The same with pictures and headings, for ReportPage.
Json EvaluationPage(const Evaluation& evaluation, const Json& figures);
/// A few lines for the terminal.
std::string EvaluationText(const Evaluation& evaluation);

}  // namespace pathfit::app
