#pragma once

#include "renderer/derivative/path_adjoint.h"
#include "renderer/render_options.h"
#include "renderer/render_stats.h"
#include "renderer/sampler/lattice_sampler.h"

namespace pathfit::renderer {

/// Mean radiance and coverage of one pixel under the box filter, before the sensor's gain. The
/// numbers of a pixel are a function of (seed, view, pixel, sample) only. `context` must have
/// been made for the same camera.
Rgba EstimatePixel(const PathContext& context,
                   const CameraModel& camera,
                   const RenderOptions& options,
                   int x,
                   int y,
                   RenderStats& stats);

/// The same number, bit for bit, and the sum over its samples of the interior derivative (image
/// form) in `sum`, not yet divided by the sample count. `recorder` is scratch space.
Rgba EstimatePixelWithDerivative(const PathContext& context,
                                 const CameraModel& camera,
                                 const RenderOptions& options,
                                 const ActiveParameters& active,
                                 int x,
                                 int y,
                                 PathRecorder& recorder,
                                 DerivativeAccumulator& sum,
                                 RenderStats& stats);

}  // namespace pathfit::renderer
