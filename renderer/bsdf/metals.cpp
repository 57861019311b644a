#include "renderer/bsdf/metals.h"

#include <array>
#include <cstddef>

namespace pathfit::renderer {
namespace {

constexpr std::array<std::string_view, 10> kNames = {"aluminium",
                                                     "chromium",
                                                     "copper",
                                                     "gold",
                                                     "iron",
                                                     "nickel",
                                                     "platinum",
                                                     "silver",
                                                     "titanium",
                                                     "tungsten"};
constexpr std::array<ConductorConstants, kNames.size()> kConstants = {{
    {{1.37, 0.96, 0.62}, {7.62, 6.69, 5.47}},
    {{3.11, 3.18, 2.32}, {3.33, 3.33, 3.14}},
    {{0.27, 1.01, 1.24}, {3.38, 2.58, 2.39}},
    {{0.19, 0.42, 1.38}, {3.40, 2.47, 1.91}},
    {{2.91, 2.95, 2.58}, {3.09, 2.93, 2.77}},
    {{1.97, 1.78, 1.63}, {3.72, 3.29, 2.66}},
    {{2.38, 2.08, 1.85}, {4.27, 3.72, 3.14}},
    {{0.056, 0.060, 0.040}, {4.26, 3.60, 2.65}},
    {{2.74, 2.54, 2.27}, {3.81, 3.43, 3.04}},
    {{4.37, 3.30, 3.00}, {3.50, 2.60, 2.27}},
}};

}  // namespace

std::optional<ConductorConstants> NamedMetal(std::string_view name) {
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (kNames[i] == name) return kConstants[i];
  }
  return std::nullopt;
}

std::span<const std::string_view> NamedMetals() { return kNames; }

}  // namespace pathfit::renderer
