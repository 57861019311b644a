#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "renderer/math/vector.h"

namespace pathfit::renderer {

struct SineCosine {
  double sine = 0.0, cosine = 1.0;
};
/// Of 2 pi u, 0 <= u <= 1, to 2e-16: no call, no branch.
inline SineCosine SineCosineOfTurn(double u) {
  // The nearest quarter of a turn is taken off, which is exact.
  const int quarter = static_cast<int>(4.0 * u + 0.5);
  const double x = (u - 0.25 * quarter) * (2.0 * std::numbers::pi);
  const double x2 = x * x;
  // Taylor series: |x| <= pi / 4.
  constexpr std::array<double, 17> kInverse = [] {
    std::array<double, 17> inverse{1.0};  // of factorials
    for (std::size_t i = 1; i < inverse.size(); ++i) {
      inverse[i] = inverse[i - 1] / static_cast<double>(i);
    }
    return inverse;
  }();
  double sine = -kInverse[15];
  double cosine = kInverse[16];
  sine = sine * x2 + kInverse[13];
  cosine = cosine * x2 - kInverse[14];
  sine = sine * x2 - kInverse[11];
  cosine = cosine * x2 + kInverse[12];
  sine = sine * x2 + kInverse[9];
  cosine = cosine * x2 - kInverse[10];
  sine = sine * x2 - kInverse[7];
  cosine = cosine * x2 + kInverse[8];
  sine = sine * x2 + kInverse[5];
  cosine = cosine * x2 - kInverse[6];
  sine = sine * x2 - kInverse[3];
  cosine = cosine * x2 + kInverse[4];
  sine = x + x * (x2 * sine);
  cosine = 1.0 - 0.5 * x2 + x2 * x2 * cosine;
  // Quarters are even by chance: branches on them would be guessed wrong half of the time.
  const auto turns = static_cast<std::uint64_t>(quarter);
  const auto bits_s = std::bit_cast<std::uint64_t>(sine);
  const auto bits_c = std::bit_cast<std::uint64_t>(cosine);
  const std::uint64_t swap = (bits_s ^ bits_c) & (0 - (turns & 1));
  return {std::bit_cast<double>(bits_s ^ swap ^ ((turns & 2) << 62)),
          std::bit_cast<double>(bits_c ^ swap ^ (((turns + 1) & 2) << 62))};
}

/// Each warp maps two uniform numbers to a direction around +z; densities are per steradian.
inline Vec3 SampleCosineHemisphere(double u0, double u1) {
  const double radius = std::sqrt(u0);
  const auto [sine, cosine] = SineCosineOfTurn(u1);
  return {radius * cosine, radius * sine, std::sqrt(std::max(0.0, 1.0 - u0))};
}
inline double CosineHemispherePdf(double cos_theta) {
  return cos_theta > 0.0 ? cos_theta * std::numbers::inv_pi : 0.0;
}

inline Vec3 SampleUniformHemisphere(double u0, double u1) {
  const double radius = std::sqrt(std::max(0.0, 1.0 - u0 * u0));
  const auto [sine, cosine] = SineCosineOfTurn(u1);
  return {radius * cosine, radius * sine, u0};
}
inline double UniformHemispherePdf() { return 0.5 * std::numbers::inv_pi; }

/// Density 1 / (4 pi).
inline Vec3 SampleUniformSphere(double u0, double u1) {
  const double z = 1.0 - 2.0 * u0;
  const double radius = std::sqrt(std::max(0.0, 1.0 - z * z));
  const auto [sine, cosine] = SineCosineOfTurn(u1);
  return {radius * cosine, radius * sine, z};
}

}  // namespace pathfit::renderer
