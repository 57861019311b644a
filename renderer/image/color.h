#pragma once

namespace pathfit::renderer {

/// IEC 61966-2-1 transfer curve, per channel, on 0..1 (larger values follow the power branch).
double LinearFromSrgb(double encoded);
double SrgbFromLinear(double linear);

}  // namespace pathfit::renderer
