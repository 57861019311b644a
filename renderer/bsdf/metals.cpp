#include "renderer/bsdf/metals.h"

#include <algorithm>
#include <array>

namespace pathfit::renderer {
namespace {

constexpr std::array<Metal, 10> kMetals = {{
    {"aluminium", {1.37, 0.96, 0.62}, {7.62, 6.69, 5.47}},
    {"chromium", {3.11, 3.18, 2.32}, {3.33, 3.33, 3.14}},
    {"copper", {0.27, 1.01, 1.24}, {3.38, 2.58, 2.39}},
    {"gold", {0.19, 0.42, 1.38}, {3.40, 2.47, 1.91}},
    {"iron", {2.91, 2.95, 2.58}, {3.09, 2.93, 2.77}},
    {"nickel", {1.97, 1.78, 1.63}, {3.72, 3.29, 2.66}},
    {"platinum", {2.38, 2.08, 1.85}, {4.27, 3.72, 3.14}},
    {"silver", {0.056, 0.060, 0.040}, {4.26, 3.60, 2.65}},
    {"titanium", {2.74, 2.54, 2.27}, {3.81, 3.43, 3.04}},
    {"tungsten", {4.37, 3.30, 3.00}, {3.50, 2.60, 2.27}},
}};

}  // namespace

std::span<const Metal> NamedMetals() { return kMetals; }

std::optional<Metal> NamedMetal(std::string_view name) {
  const auto* metal = std::ranges::find(kMetals, name, &Metal::name);
  return metal == kMetals.end() ? std::nullopt : std::optional(*metal);
}

}  // namespace pathfit::renderer
