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

/// Angle of (x, y) from the x-axis as a share of a turn, in [0, 1], to 2e-16: atan2(y, x) / (2 pi),
/// plus 1 where that is negative. No call, no branch.
inline double TurnOf(double y, double x) {
  const double a = std::min(std::abs(x), std::abs(y));
  const double b = std::max(std::abs(x), std::abs(y));
  // Beyond an eighth of the half circle the angle is measured from the diagonal.
  const bool is_steep = a > (std::numbers::sqrt2 - 1.0) * b;
  const double over = is_steep ? a - b : a;
  const double under = is_steep ? a + b : b;
  const double t = under > 0.0 ? over / under : 0.0;
  const double z = t * t;
  // Minimax polynomial of atan(t) / (2 pi t) in z = t^2 up to z = (sqrt(2) - 1)^2, to 6e-18.
  constexpr std::array<double, 11> kMinimax = {
      0.0033637991121386406,
      -0.00692014002952943,
      0.00905328897479615,
      -0.01056826053314365,
      0.012238941110840396,
      -0.014468414713824675,
      0.017683874718384725,
      -0.02273642027500392,
      0.03183098861655692,
      -0.053051647697290656,
      0.15915494309189532,
  };
  const auto pair = [&](std::size_t i) { return kMinimax[i + 1] + kMinimax[i] * z; };
  const double z2 = z * z;
  const double z4 = z2 * z2;
  double turn = (kMinimax[0] * z2 + pair(1)) * z4 + (pair(3) * z2 + pair(5));
  turn = turn * z4 + (pair(7) * z2 + pair(9));
  turn = turn * t + (is_steep ? 0.125 : 0.0);
  turn = std::abs(y) > std::abs(x) ? 0.25 - turn : turn;
  turn = x < 0.0 ? 0.5 - turn : turn;
  return y < 0.0 ? 1.0 - turn : turn;
}

/// acos(cosine) / pi, |cosine| <= 1: from 0 at the pole above to 1 below.
inline double PolarShare(double cosine) {
  return 2.0 * TurnOf(std::sqrt((1.0 - cosine) * (1.0 + cosine)), cosine);
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
