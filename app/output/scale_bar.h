#pragma once

#include <array>

#include "renderer/image/image.h"

namespace pathfit::app {

/// A false-colour image on a wider or equal canvas with its key below: the colours from -scale to
/// +scale and the number. `key` maps [-1, 1] to a display colour.
renderer::Image WithScaleBar(const renderer::Image& image,
                             double scale,
                             std::array<float, 3> (*key)(double));

}  // namespace pathfit::app
