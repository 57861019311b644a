#include "renderer/image/color.h"

#include <algorithm>
#include <cmath>

namespace pathfit::renderer {

double LinearFromSrgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

double ClampedSrgb(double linear) { return SrgbFromLinear(std::clamp(linear, 0.0, 1.0)); }

double SrgbFromLinear(double linear) {
  return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

}  // namespace pathfit::renderer
