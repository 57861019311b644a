#pragma once

#include <vector>

#include "optim/observation/observation.h"
#include "optim/parameter/parameter_set.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// Moves `values` into the bounds; false if that would visibly change a group (a nearly black texel
/// may be lifted).
bool ClampToBounds(const ParameterSet& set, std::vector<double>& values);

/// The gains that the sensors have now.
ExposureModel MakeExposureModel(const renderer::Scene& scene, const ExposurePrior& prior);

/// Gains and lights share a factor that no photo can tell, and one per channel where white balances
/// are free. Where every light of the scene is free (intensity or texels), moves the mean log gain
/// of the fitted views back to that of `exposure.start_gains`, mean white balances to 1, and the
/// factors into the lights; the images stay the same. Does nothing if no gain is free, a light is
/// fixed, or a value would leave its bounds.
void FixExposureGauge(const ParameterSet& set,
                      const std::vector<int>& fitted,
                      const ExposureModel& exposure,
                      renderer::Scene& scene);

/// What of a view's gains a fit finds: nothing, one for all channels, or one for each.
enum class FreeGains { kNone, kOne, kPerChannel };
FreeGains FreeGainsOf(const std::vector<UnknownSpec>& unknowns);

/// Factors on the gains with which `halves` fit a held-out view's photo best (least squares over
/// its valid colours; the product of the halves keeps noise out of the denominator). 1 if the view
/// says nothing, and of what is not free.
renderer::Rgb EstimateGainFactors(const ViewLevel& level,
                                  const renderer::Film& a,
                                  const renderer::Film& b,
                                  FreeGains free);

}  // namespace pathfit::optim
