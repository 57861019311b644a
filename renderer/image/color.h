#pragma once

namespace pathfit::renderer {

/// IEC 61966-2-1 transfer curve, per channel, on 0..1 (larger values follow the power branch).
double LinearFromSrgb(double encoded);
double SrgbFromLinear(double linear);
/// Of the number clamped to [0, 1]: what a stored picture can hold.
double ClampedSrgb(double linear);

}  // namespace pathfit::renderer
