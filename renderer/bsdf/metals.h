#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "renderer/math/rgb.h"

namespace pathfit::renderer {

/// Complex index of refraction eta + i k per linear Rec.709 channel.
struct ConductorConstants {
  Rgb eta, k;
};

/// Index of a metal by its English name in lower case ("gold", "aluminium" ...), empty for a name
/// not in NamedMetals(). Values of evaporated or polished metal at about 630, 550 and 450 nm, read
/// from published tables of optical constants and rounded to two or three digits.
std::optional<ConductorConstants> NamedMetal(std::string_view name);

/// All names NamedMetal knows, in alphabetical order.
std::span<const std::string_view> NamedMetals();

}  // namespace pathfit::renderer
