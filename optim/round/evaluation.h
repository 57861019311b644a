#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "optim/problem/fit_views.h"
#include "optim/problem/image_source.h"
#include "optim/problem/scene_image_source.h"
#include "optim/problem/split_half_cost.h"
#include "optim/problem/view_quality.h"
#include "optim/ranks/division.h"
#include "optim/round/exposure_gauge.h"
#include "optim/round/fit_report.h"
#include "optim/round/fit_spec.h"

namespace pathfit::optim {

/// Cost of a scene on one sample set, in reported units: photos, silhouettes and priors.
struct EvaluatedCost {
  double image = 0.0, silhouette = 0.0, priors = 0.0;
  [[nodiscard]] double Total() const { return image + silhouette + priors; }
};

/// Costs on the same samples.
struct CostComparison {
  std::vector<EvaluatedCost> costs;
  std::vector<double> squared_differences;  ///< of all pixels' shares, each with each
  /// Whether i costs more than j than their noise explains, as if all that differs between pixels
  /// were noise.
  [[nodiscard]] bool IsSurelyWorse(std::size_t i, std::size_t j) const;
};

struct ComparedScene {
  std::unique_ptr<SceneImageSource> source;
  double priors_in_solver_units = 0.0;
};

/// One view at a time, so that its pixels are kept of no other. The same on every rank.
CostComparison CompareCosts(const std::vector<ComparedScene>& scenes,
                            const FitViews& views,
                            const LossSpec& loss,
                            const SampleHalves& samples,
                            Division& division);

/// One view rendered for a report. Of a held-out view only `gain_factors`, of what is `free` of
/// gains, are estimated from its own photo; the film has them applied, and what is said of it.
/// `level` is the view's, unpacked.
struct ReportedView {
  renderer::Film film;
  ViewQuality quality;
  ImageCosts costs;
  renderer::Rgb gain_factors = renderer::Rgb::Constant(1.0);
};
ReportedView RenderForReport(const ImageSource& source,
                             const FitViews& views,
                             int view,
                             const ViewLevel& level,
                             const LossSpec& loss,
                             const SampleHalves& samples,
                             FreeGains free);

/// The photos of a fit at the resolutions of its stages, and renderings to compare with them.
class FitEvaluation {
 public:
  /// All arguments must outlive it. `free`: the gains of held-out views are estimated.
  FitEvaluation(const ObservationSet& observations,
                const FitSpec& spec,
                const ExposureModel& exposure,
                FreeGains free,
                const renderer::CancelFlag* cancel,
                Division& division)
      : observations_(observations),
        spec_(spec),
        exposure_(exposure),
        free_gains_(free),
        cancel_(cancel),
        division_(division) {}

  /// On the first rank. Valid until another scale is asked for.
  const FitViews& ViewsAt(double scale);
  /// The same on all ranks at once: others than the first need no photo for it.
  const FitViews& SharedViewsAt(double scale);

  /// `layout` may be empty where no values are set.
  [[nodiscard]] std::unique_ptr<SceneImageSource> MakeSource(
      const renderer::Scene& scene,
      const renderer::ParameterLayout& layout,
      const FitViews& views) const;

  /// Of reports and of candidates for the end of a stage: one set per stage, apart from every
  /// round's. Edges play no part in images.
  [[nodiscard]] SampleHalves Samples(int stage, int spp) const;
  static constexpr int kFirstSpp = 4;  ///< tells most candidates for a stage's end apart
  static constexpr int kMostSpp = 32;  ///< for the others
  /// Of pictures on the way and of the last ones, of photos whose smaller side has so many pixels.
  /// They are looked at reduced: large ones need few; of small ones few pixels make the figures.
  static int DraftSpp(double side_px) {
    return side_px < 0.25 * kUsualSide_px ? kMostSpp : SppOfSide(side_px, kMostSpp / 4);
  }
  static int SppOfPictures(double side_px) { return SppOfSide(side_px, kMostSpp); }

  /// Fills the report's views and means, and shows the pictures to `observer`. They are rendered at
  /// the last stage's resolution, since reports of stages compare only at one. Sets the estimated
  /// gains in `scene`. Returns what the fitted photos cost there. On ranks other than the first it
  /// only renders.
  ImageCosts Report(const SampleHalves& samples,
                    FitObserver& observer,
                    renderer::Scene& scene,
                    StageReport& report) const;

 private:
  static constexpr double kUsualSide_px = 256.0;
  static int SppOfSide(double side_px, int most) {
    const double usual = kUsualSide_px / side_px;
    return static_cast<int>(
        std::clamp(most * usual * usual, std::max(2.0, 0.25 * most), 1.0 * most));
  }

  const ObservationSet& observations_;
  const FitSpec& spec_;
  const ExposureModel& exposure_;
  FreeGains free_gains_;
  const renderer::CancelFlag* cancel_;
  Division& division_;
  std::optional<FitViews> views_;
  double views_scale_ = 0.0;
};

}  // namespace pathfit::optim
