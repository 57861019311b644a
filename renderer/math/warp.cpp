#include "renderer/math/warp.h"

#include <algorithm>
#include <numbers>

namespace pathfit::renderer {

Vec3 SampleCosineHemisphere(double u0, double u1) {
  const double radius = std::sqrt(u0);
  const double phi = 2.0 * std::numbers::pi * u1;
  return {radius * std::cos(phi), radius * std::sin(phi), std::sqrt(std::max(0.0, 1.0 - u0))};
}

double CosineHemispherePdf(double cos_theta) {
  return cos_theta > 0.0 ? cos_theta * std::numbers::inv_pi : 0.0;
}

Vec3 SampleUniformHemisphere(double u0, double u1) {
  const double radius = std::sqrt(std::max(0.0, 1.0 - u0 * u0));
  const double phi = 2.0 * std::numbers::pi * u1;
  return {radius * std::cos(phi), radius * std::sin(phi), u0};
}

Vec3 SampleUniformSphere(double u0, double u1) {
  const double z = 1.0 - 2.0 * u0;
  const double radius = std::sqrt(std::max(0.0, 1.0 - z * z));
  const double phi = 2.0 * std::numbers::pi * u1;
  return {radius * std::cos(phi), radius * std::sin(phi), z};
}

double UniformHemispherePdf() { return 0.5 * std::numbers::inv_pi; }

}  // namespace pathfit::renderer
