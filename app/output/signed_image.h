#pragma once

#include <filesystem>

#include "renderer/image/image.h"

namespace pathfit::app {

/// Largest magnitude of the luminance of a film that is not an outlier: its 99.5th percentile, or
/// the maximum if that is zero.
double SignedScale(const renderer::Film& film);

/// Luminance from -scale (blue) over 0 (white) to +scale (red), encoded for display, with a bar of
/// these colours and numbers below.
renderer::Image SignedImage(const renderer::Film& film, double scale);

}  // namespace pathfit::app
