#pragma once

#include <array>
#include <optional>
#include <vector>

#include "renderer/renderer.h"

namespace pathfit::optim {

/// Derivative estimate against central differences of the same images, both in expectation.
struct GradientCheckOptions {
  /// One derivative replicate; the others have seeds above its own.
  renderer::RenderOptions render{
      {.spp = 64, .sppe = 16.0, .spp_direct = 4.0, .spp_indirect = 4.0, .spp_pixel = 8.0}, {}};
  /// Other settings than these are found; none: `render` has all.
  std::optional<renderer::DerivativeChoice> given;
  int replicates = 32;  ///< independent repetitions, from which the error bars come
  /// Of one replicate of the two displaced images, which share their random numbers.
  int difference_spp = 256;
  double step = 1e-3;  ///< half distance of the central difference, in units of the direction
};

using Term = renderer::DerivativeTerm;

/// Replicates of the terms of one directional derivative and of its central difference.
struct GradientCheckResult {
  /// By term; empty: it was not run.
  std::array<std::vector<renderer::Film>, renderer::kNumDerivativeTerms> terms;
  std::vector<renderer::Film> difference;
  /// The most that one sample of a pixel adds to the mean difference when it changes sides of an
  /// edge, or is drawn from another lobe. Where an edge barely touches a tile, or a step hardly
  /// changes a lobe's chance, few or no samples do, and the spread of the replicates tells nothing:
  /// error bars hold the spread of their number as well.
  renderer::Film quantum;
  bool changes_lobes = false;  ///< the interior term, too, is that of samples that change
  /// The difference at half the step, of the first replicates and with their random numbers: what
  /// it differs by tells the truncation error of `difference`. Empty: that is taken for none.
  std::vector<renderer::Film> halved;

  [[nodiscard]] const std::vector<renderer::Film>& operator[](Term term) const {
    return terms[static_cast<std::size_t>(term)];
  }
};

/// z statistics of the sum of the terms minus the difference over square tiles of an image. Tiles
/// where both sides are exactly constant and equal count with z = 0, unequal ones with infinity.
struct GradientComparison {
  std::int64_t count = 0;  ///< tiles times channels that carry noise or signal
  double z_rms = 0.0, z_max = 0.0;
  double z_limit = 0.0;  ///< exceeded by a right derivative as rarely as `sigma` by one normal
                         ///< number (Sidak, Student t)
  double signal_to_noise = 0.0;  ///< rms of the difference over rms of the error bars
  double truncation = 0.0;  ///< rms of what the step's own error adds to them, over that of the
                            ///< difference
};

/// Derivative in `direction` (flat, over the scalars of `layout`) as seen by `camera`, the scene's
/// sensor of that index at any size, or any camera if `sensor` is -1. Terms that are off or
/// cannot contribute (form, number of bounces, nothing moves) are not run.
/// Where a value stands at a bound of its kind (a texel at 0), everything is taken a step inside
/// it. Throws SceneError, naming the scalars, where a step is lost in a value or drowns it, and
/// when a step leaves the valid scenes all the same.
GradientCheckResult CheckGradient(const renderer::Scene& scene,
                                  const renderer::Camera& camera,
                                  int sensor,
                                  const renderer::ParameterLayout& layout,
                                  const std::vector<double>& direction,
                                  const GradientCheckOptions& options,
                                  const renderer::CancelFlag* cancel = nullptr);

/// Draws `result.halved`, where the result, of the same arguments, is compared more sharply than
/// its step allows: a central difference is off by a sixth of the step's square times the third
/// derivative.
void AddHalvedDifference(const renderer::Scene& scene,
                         const renderer::Camera& camera,
                         int sensor,
                         const renderer::ParameterLayout& layout,
                         const std::vector<double>& direction,
                         const GradientCheckOptions& options,
                         GradientCheckResult& result,
                         const renderer::CancelFlag* cancel = nullptr);

/// `tile`: pixels per side; 0 = the whole image is one tile.
GradientComparison Compare(const GradientCheckResult& result, int tile, double sigma = 4.0);

/// The derivative of each replicate: the sum of its terms.
std::vector<renderer::Film> Estimates(const GradientCheckResult& result);

/// Mean over replicates.
renderer::Film MeanFilm(const std::vector<renderer::Film>& films);

}  // namespace pathfit::optim
