#include "renderer/texture/texture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "renderer/core/check.h"

namespace pathfit::renderer {
namespace {

/// The two texels of one axis around a coordinate, which lies `fraction` of the way from `low` to
/// `high`.
struct AxisLookup {
  int low = 0;
  int high = 0;
  double fraction = 0.0;
  double slope = 0.0;  ///< of the fraction by the texture coordinate
};

AxisLookup LookUpAxis(double coordinate, int size, TextureWrap wrap) {
  AxisLookup axis;
  if (!std::isfinite(coordinate)) return axis;
  if (wrap == TextureWrap::kRepeat) {
    // Reduced before scaling: exact however far out the coordinate lies.
    const double place = (coordinate - std::floor(coordinate)) * size - 0.5;
    const double below = std::floor(place);
    const int index = static_cast<int>(below);  // -1 to size - 1
    axis.low = (index + size) % size;
    axis.high = (index + 1) % size;
    axis.fraction = place - below;
    axis.slope = size;
    return axis;
  }
  const double place = coordinate * size - 0.5;
  const double inside = std::clamp(place, 0.0, size - 1.0);
  axis.low = static_cast<int>(inside);
  axis.high = std::min(axis.low + 1, size - 1);
  axis.fraction = inside - axis.low;
  axis.slope = inside == place ? size : 0.0;
  return axis;
}

}  // namespace

TextureLookup LookUpTexture(const Texture& texture, const Vec2& uv) {
  PATHFIT_DCHECK(texture.width > 0 && texture.height > 0 &&
                 texture.texels.size() == static_cast<std::size_t>(texture.width) *
                                              static_cast<std::size_t>(texture.height));
  const AxisLookup x = LookUpAxis(uv.x, texture.width, texture.wrap);
  const AxisLookup y = LookUpAxis(uv.y, texture.height, texture.wrap);
  // Rows are counted from the top, v from the bottom.
  const int low_row = (texture.height - 1 - y.low) * texture.width;
  const int high_row = (texture.height - 1 - y.high) * texture.width;
  TextureLookup lookup;
  lookup.texel = {low_row + x.low, low_row + x.high, high_row + x.low, high_row + x.high};
  lookup.weight = {(1.0 - x.fraction) * (1.0 - y.fraction),
                   x.fraction * (1.0 - y.fraction),
                   (1.0 - x.fraction) * y.fraction,
                   x.fraction * y.fraction};
  std::array<Rgb, 4> value;
  for (std::size_t k = 0; k < 4; ++k) {
    value[k] = texture.texels[static_cast<std::size_t>(lookup.texel[k])];
    lookup.value += value[k] * lookup.weight[k];
  }
  lookup.du = (value[1] - value[0]) * (x.slope * (1.0 - y.fraction)) +
              (value[3] - value[2]) * (x.slope * y.fraction);
  lookup.dv = (value[2] - value[0]) * (y.slope * (1.0 - x.fraction)) +
              (value[3] - value[1]) * (y.slope * x.fraction);
  return lookup;
}

Rgb TextureValue(const Texture& texture, const Vec2& uv) {
  return LookUpTexture(texture, uv).value;
}

}  // namespace pathfit::renderer
