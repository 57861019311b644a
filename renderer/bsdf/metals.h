#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "renderer/math/rgb.h"

namespace pathfit::renderer {

/// Complex index of refraction eta + i k per linear Rec.709 channel. Values of evaporated or
/// polished metal at about 630, 550 and 450 nm, read from published tables of optical constants and
/// rounded to two or three digits.
struct Metal {
  std::string_view name;  ///< English, in lower case: "gold", "aluminium"
  Rgb eta, k;
};

/// In alphabetical order.
std::span<const Metal> NamedMetals();
/// Empty for a name not in NamedMetals().
std::optional<Metal> NamedMetal(std::string_view name);

}  // namespace pathfit::renderer
