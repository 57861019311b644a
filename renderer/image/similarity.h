#pragma once

#include "renderer/image/image.h"

namespace pathfit::renderer {

/// Mean structural similarity of two pictures of the same size [Wang2004]: of the mean of
/// their channels, with a Gaussian window of sigma 1.5 over 11 x 11 pixels and the constants .01
/// and .03 of the range 0..1; 1 where both are equal. `weight`: one channel, or empty for all;
/// pixels of weight 0 are in no window, and the mean is weighted. NaN where nothing has weight.
double StructuralSimilarity(const Image& a, const Image& b, const Image& weight);

}  // namespace pathfit::renderer
