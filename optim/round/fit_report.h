#pragma once

#include <map>
#include <string>
#include <vector>

#include "optim/observation/observation.h"
#include "renderer/image/image.h"
#include "renderer/math/rgb.h"
#include "renderer/render_options.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// One row of metrics.csv. Costs, noise and PSNR are of the round's start, whose parameters this
/// round's samples know nothing of: unbiased. Costs are means per valid pixel-channel
/// (problem/fit_views.h).
struct RoundReport {
  int step = 0;  ///< counts rounds of all stages from 1
  std::string stage;
  int stage_index = 0, num_stages = 0;
  int round = 0, max_rounds = 0;  ///< within the stage, from 1
  double wall_s = 0.0;            ///< since the run began, resumed time included
  double cost_total = 0.0, cost_image = 0.0, cost_silhouette = 0.0, cost_priors = 0.0;
  /// (after - before) / |before| by the accepted step, on this round's samples: negative when the
  /// cost falls, 0 when no step was accepted.
  double cost_change_rel = 0.0;
  double gradient_max = 0.0, step_norm = 0.0, trust_radius = 0.0;
  /// By how much the step moved things in the images, in pixels of this round (MotionGuard).
  double motion = 0.0;
  bool accepted = false;
  double image_scale = 1.0;                  ///< of the photos in this round
  renderer::SampleBudget samples{.spp = 0};  ///< of both halves together
  double noise_relative = 0.0;  ///< rms of the half difference over rms of the residual
  // Means over fitted and held-out views of what is known (ViewQuality), NaN if nothing is.
  double psnr_linear_fit = 0.0, psnr_linear_val = 0.0;  ///< dB, inside the mask
  double iou_fit = 0.0, iou_val = 0.0;                  ///< coverage > 1/2 against the mask
  // After the round, of the meshes whose vertices move (renderer/geometry/mesh_folds.h).
  int moving_vertices = 0;
  int folded_edges = 0, crossing_triangles = 0;
  double render_s = 0.0, jacobian_s = 0.0, linear_s = 0.0;
  double jacobian_mb = 0.0;
  double peak_rss_mb = 0.0;
  std::string linear_solver;
  std::string solver_failure;  ///< the solver's own words if it gave up; empty = it did not
};

/// Quality of the views at one moment, from one common set of samples; NaN where it is not known
/// (ViewQuality).
struct ViewReport {
  std::string name;
  bool validation = false;
  double psnr_linear = 0.0;  ///< colours inside the mask, peak 1
  double psnr_srgb = 0.0;    ///< after the sRGB curve and clamping to 0..1
  double iou = 1.0;
  double gain = 1.0;
};

/// Start of the run and end of each stage.
struct StageReport {
  std::string stage;  ///< "start" or the stage's name
  double wall_s = 0.0;
  int rounds = 0;
  /// Same samples for both; where few told them apart, the end's is of the reported pictures, and
  /// the start's differs from it as they said.
  double cost_before = 0.0, cost_after = 0.0;
  std::string kept;  ///< which candidate was kept: "averaged", "last" or "start"
  std::vector<ViewReport> views;
  // Means over fitted and held-out views of what is known, NaN if nothing is.
  double psnr_srgb_fit = 0.0, psnr_srgb_val = 0.0;
  double psnr_linear_fit = 0.0, psnr_linear_val = 0.0;
  double iou_fit = 0.0, iou_val = 0.0;
  int folded_edges = 0, crossing_triangles = 0;  ///< of the meshes whose vertices moved
  std::string stop_reason;
};

/// What tells the scale that base colours share with lights, or with exposures where lights are
/// known.
enum class GaugeSource {
  kKnownLight,  ///< a light that is not free, in photos of known exposure
  kKnownColor,  ///< the base colour of a surface that is not free
  kPhotos,      ///< what of the photos is not proportional to both: highlights, light between
                ///< surfaces, lights that are seen
  kMeanColor,   ///< the rule: the mean base colour
  kNothing,     ///< photos are proportional to both: priors and the start
};

/// The rule that was in force and what came of it; colours are means over surfaces.
struct GaugeReport {
  GaugeSource source = GaugeSource::kPhotos;
  std::string known;     ///< name of the light or material
  renderer::Rgb wanted;  ///< of kMeanColor
  renderer::Rgb mean;    ///< of the result: of ColorGauge::material, or all
  renderer::Rgb start;   ///< the same of what the run began with
  /// Lights are known, and exposures are what shares the scale.
  bool is_of_exposures = false;
  /// Strength over that at the start, geometric mean of all free lights; or of the photos' gains.
  renderer::Rgb factors;
};

/// Listens to a fit; called from the thread that runs it, between rounds.
class FitObserver {
 public:
  FitObserver() = default;
  FitObserver(const FitObserver&) = delete;
  FitObserver& operator=(const FitObserver&) = delete;
  virtual ~FitObserver() = default;
  virtual void OnRound(const RoundReport& report) = 0;
  /// The scene that the report of a stage is about, before its pictures, and what is known of its
  /// standard errors (FitResult::standard_errors).
  virtual void OnScene(const std::string& /*stage*/,
                       const renderer::Scene& /*scene*/,
                       const std::map<std::string, std::vector<double>>& /*standard_errors*/) {}
  /// Rendering of a view for the report of a stage, at the last stage's resolution, and what was
  /// observed at that size; of all views, before the report.
  virtual void OnView(const std::string& stage,
                      std::size_t view,
                      const renderer::Film& image,
                      const ViewLevel& observed) = 0;
  virtual void OnStage(const StageReport& report) = 0;
  virtual void OnMessage(const std::string& text) = 0;
  /// What may spoil the result.
  virtual void OnWarning(const std::string& text) = 0;
  /// What is not in the derivative (renderer::DerivativeLimits), at the start.
  virtual void OnLimit(const std::string& limit) { OnWarning("not in the derivative: " + limit); }
};

/// Of ranks other than the first, which do not speak.
class SilentObserver final : public FitObserver {
 public:
  void OnRound(const RoundReport& /*report*/) override {}
  void OnView(const std::string& /*stage*/,
              std::size_t /*view*/,
              const renderer::Film& /*image*/,
              const ViewLevel& /*observed*/) override {}
  void OnStage(const StageReport& /*report*/) override {}
  void OnMessage(const std::string& /*text*/) override {}
  void OnWarning(const std::string& /*text*/) override {}
};

}  // namespace pathfit::optim
