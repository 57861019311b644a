#include "renderer/bsdf/visible_normal.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/math/inverse_erf.h"

namespace pathfit::renderer {

namespace {

/// Slope of a Beckmann surface of alpha = 1 along the azimuth of a direction with this cosine and
/// sine, as seen from there, s < cot: the density is (cos - sin s) exp(-s^2) over its integral
/// below. With sin = 0, the slope along any line of what is seen from above.
double VisibleSlope(double cos, double sin, double u) {
  constexpr double kEnd = 6.0;  // erfc(6) = 2e-17
  constexpr int kMaxSteps = 60;
  constexpr double kTolerance = 1e-14;  // of the probability
  const auto bell = [](double s) { return std::exp(-s * s) * std::numbers::inv_sqrtpi; };
  const auto below = [&](double s) { return 0.5 * (cos * std::erfc(-s) + sin * bell(s)); };
  double low = -kEnd;
  double high = cos < kEnd * sin ? cos / sin : kEnd;
  const double all = below(high);
  const double share = u * all;
  double s =
      std::clamp(u < 0.5 ? -RoughInverseErf(2.0 * u) : RoughInverseErf(2.0 - 2.0 * u), low, high);
  for (int i = 0; i < kMaxSteps; ++i) {
    const double excess = below(s) - share;
    if (std::abs(excess) <= kTolerance * all) break;
    (excess > 0.0 ? high : low) = s;
    double next = s - excess / ((cos - sin * s) * bell(s));
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    s = next;
  }
  return s;
}

}  // namespace

Vec3 SampleVisibleNormal(Ggx /*distribution*/, const Vec3& wo, double alpha, double u0, double u1) {
  // Stretched to alpha = 1, visible normals are half vectors of wo and a uniform spherical cap.
  const Vec3 stretched = Normalized(Vec3{alpha * wo.x, alpha * wo.y, wo.z});
  const double phi = 2.0 * std::numbers::pi * u0;
  const double z = (1.0 - u1) * (1.0 + stretched.z) - stretched.z;
  const double radius = std::sqrt(std::max(0.0, 1.0 - z * z));
  const Vec3 h = Vec3{radius * std::cos(phi), radius * std::sin(phi), z} + stretched;
  return Normalized(Vec3{alpha * h.x, alpha * h.y, std::max(1e-12, h.z)});
}

Vec3 SampleVisibleNormal(
    Beckmann /*distribution*/, const Vec3& wo, double alpha, double u0, double u1) {
  const Vec3 stretched = Normalized(Vec3{alpha * wo.x, alpha * wo.y, wo.z});
  const double sin = std::hypot(stretched.x, stretched.y);
  const double along = VisibleSlope(stretched.z, sin, u0);
  const double across = VisibleSlope(1.0, 0.0, u1);
  const double x = sin > 0.0 ? stretched.x / sin : 1.0;
  const double y = sin > 0.0 ? stretched.y / sin : 0.0;
  return Normalized(
      Vec3{-alpha * (along * x - across * y), -alpha * (along * y + across * x), 1.0});
}

double MirroredFacing(double cos_i, double cos_o, double dot_io) {
  return std::max(0.0, 2.0 * cos_o * (cos_i + cos_o) / (1.0 + dot_io) - 1.0);
}

}  // namespace pathfit::renderer
