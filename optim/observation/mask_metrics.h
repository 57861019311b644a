#pragma once

#include "renderer/image/image.h"

namespace pathfit::optim {

/// Intersection over union of a rendered coverage (> 1/2) and a mask (> 1/2), both of one channel
/// and the same size; 1 when both are empty.
double MaskIou(const renderer::Image& coverage, const renderer::Image& mask);

}  // namespace pathfit::optim
