#pragma once

#include "renderer/derivative/path_adjoint.h"
#include "renderer/render_stats.h"
#include "renderer/sampler/path_sampler.h"

namespace pathfit::renderer {

/// Mean radiance and coverage of one pixel under its filter, before the sensor's gain. The
/// numbers of a pixel are a function of (seed, view, pixel, sample) only. `context` must have
/// been made for the same camera.
Rgba EstimatePixel(const PathContext& context,
                   const CameraModel& camera,
                   const RenderOptions& options,
                   int x,
                   int y,
                   RenderStats& stats);

/// The same number (in image form, bit for bit), and the sum over its samples of the interior
/// derivative in `sum`, not yet divided by the sample count. `recorder` is scratch space.
/// In material form under a smooth filter, samples cover the filter's support evenly in groups of
/// four mirrored points that share all further numbers: the slope of the filter is odd, and grows
/// beyond bounds relative to the filter. [path_space 1.9]
Rgba EstimatePixelWithDerivative(const AdjointContext& context,
                                 const RenderOptions& options,
                                 int x,
                                 int y,
                                 PathRecorder& recorder,
                                 DerivativeAccumulator& sum,
                                 RenderStats& stats);

}  // namespace pathfit::renderer
