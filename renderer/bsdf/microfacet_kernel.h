#pragma once

#include <cmath>
#include <numbers>

namespace pathfit::renderer {

/// GGX distribution times height-correlated Smith visibility, D(h) V(i, o) with V = G2 / (4 cos_i
/// cos_o), from the three cosines of a reflection. Template on the number type: double, Dual or
/// ceres::Jet. Source: glTF 2.0 specification, appendix B; [Heitz 2014, eqs. 71, 99].
template <class T>
T MicrofacetReflection(const T& cos_i, const T& cos_o, const T& dot_io, const T& alpha) {
  using std::sqrt;
  const T alpha2 = alpha * alpha;
  const T sum = cos_i + cos_o;
  // cos_h^2 = (cos_i + cos_o)^2 / |wi + wo|^2; the denominator of D is cos_h^2 (alpha^2 - 1) + 1.
  const T cos_h2 = sum * sum / (T(2.0) + T(2.0) * dot_io);
  const T base = cos_h2 * (alpha2 - T(1.0)) + T(1.0);
  const T distribution = alpha2 / (T(std::numbers::pi) * base * base);
  const T root_i = sqrt(alpha2 + (T(1.0) - alpha2) * cos_i * cos_i);
  const T root_o = sqrt(alpha2 + (T(1.0) - alpha2) * cos_o * cos_o);
  return distribution * T(0.5) / (cos_i * root_o + cos_o * root_i);
}

/// Schlick's weight (1 - v.h)^5 from the cosine between the two directions.
template <class T>
T SchlickWeight(const T& dot_io) {
  using std::sqrt;
  const T half = sqrt(T(0.5) + T(0.5) * dot_io);
  const T c = T(1.0) - half;
  const T c2 = c * c;
  return c2 * c2 * c;
}

}  // namespace pathfit::renderer
