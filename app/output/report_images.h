#pragma once

#include <string>

#include "renderer/emitter/emitter.h"
#include "renderer/image/image.h"

namespace pathfit::app {

/// Longest side of the pictures in a report.
inline constexpr int kThumbnailPx = 512;
/// Signed differences are drawn from -kDifferenceScale (blue) over 0 (white) to +kDifferenceScale
/// (red), in units of the sRGB-encoded range 0..1. The same in every report, so that runs can be
/// compared.
inline constexpr double kDifferenceScale = 0.2;

/// Area-averaged copy whose longer side is at most `max_px`; never enlarged.
renderer::Image ReducedImage(const renderer::Image& image, int max_px);

/// sRGB-encoded and clamped to 0..1; numbers that are not finite become magenta, to be seen.
renderer::Image EncodedImage(const renderer::Image& linear);

/// Mean over channels of encoded(fit) - encoded(photo); pixels whose mask is at most 1/2 are grey
/// (not compared). `mask`: one channel of the same size, or empty. Encoded colours, 0..1.
renderer::Image DifferenceImage(const renderer::Image& fit,
                                const renderer::Image& photo,
                                const renderer::Image& mask);

/// Rendered coverage against a mask: grey where both see the object, red where only the rendering
/// does, blue where only the mask does, white elsewhere. One channel each, same size.
renderer::Image SilhouetteImage(const renderer::Image& coverage, const renderer::Image& mask);

/// Factor that brings the environment's bright parts (95th percentile of luminance) just below
/// white.
double EnvironmentExposure(const renderer::EnvironmentEmitter& environment);
/// Intensity times texels times `exposure`, encoded, texels repeated to at least 256 pixels of
/// width.
renderer::Image EnvironmentPicture(const renderer::EnvironmentEmitter& environment,
                                   double exposure);

}  // namespace pathfit::app
