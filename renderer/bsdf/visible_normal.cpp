#include "renderer/bsdf/visible_normal.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pathfit::renderer {

Vec3 SampleVisibleNormal(const Vec3& wo, double alpha, double u0, double u1) {
  // Stretched to alpha = 1, visible normals are half vectors of wo and a uniform spherical cap.
  const Vec3 stretched = Normalized(Vec3{alpha * wo.x, alpha * wo.y, wo.z});
  const double phi = 2.0 * std::numbers::pi * u0;
  const double z = (1.0 - u1) * (1.0 + stretched.z) - stretched.z;
  const double radius = std::sqrt(std::max(0.0, 1.0 - z * z));
  const Vec3 h = Vec3{radius * std::cos(phi), radius * std::sin(phi), z} + stretched;
  return Normalized(Vec3{alpha * h.x, alpha * h.y, std::max(1e-12, h.z)});
}

double VisibleNormalFactor(double cos_h2, double cos_o, double alpha) {
  const double alpha2 = alpha * alpha;
  const double base = cos_h2 * (alpha2 - 1.0) + 1.0;
  const double root_o = std::sqrt(alpha2 + (1.0 - alpha2) * cos_o * cos_o);
  return 2.0 * alpha2 / (std::numbers::pi * base * base * (cos_o + root_o));
}

double MirroredFacing(double cos_i, double cos_o, double dot_io) {
  return std::max(0.0, 2.0 * cos_o * (cos_i + cos_o) / (1.0 + dot_io) - 1.0);
}

}  // namespace pathfit::renderer
