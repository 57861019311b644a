#pragma once

#include <cmath>
#include <numbers>

#include "renderer/bsdf/fresnel_kernel.h"

namespace pathfit::renderer {

/// GGX distribution times height-correlated Smith visibility, D(h) V(i, o) with V = G2 / (4 cos_i
/// cos_o), from the three cosines of a reflection. Template on the number type: double, Dual or
/// ceres::Jet. Source: glTF 2.0 specification, appendix B; [Heitz2014, eqs. 71, 99].
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

/// Value and partials of MicrofacetReflection, by hand: this one is evaluated at every path vertex.
struct MicrofacetPartials {
  double value, d_cos_i, d_cos_o, d_dot_io, d_alpha;
};
inline MicrofacetPartials MicrofacetReflectionPartials(double cos_i,
                                                       double cos_o,
                                                       double dot_io,
                                                       double alpha) {
  const double alpha2 = alpha * alpha;
  const double q = 1.0 - alpha2;
  const double sum = cos_i + cos_o;
  const double inverse = 0.5 / (1.0 + dot_io);
  const double cos_h2 = sum * sum * inverse;
  const double base = 1.0 - q * cos_h2;
  const double root_i = std::sqrt(alpha2 + q * cos_i * cos_i);
  const double root_o = std::sqrt(alpha2 + q * cos_o * cos_o);
  const double shadowing = 1.0 / (cos_i * root_o + cos_o * root_i);
  const double inverse_base = 1.0 / base;
  const double value =
      alpha2 * (0.5 * std::numbers::inv_pi) * inverse_base * inverse_base * shadowing;
  // d log of the product: -2 d log base - d log of the shadowing's denominator.
  const double by_cos_h2 = 2.0 * q * inverse_base;
  const double by_sum = by_cos_h2 * 2.0 * sum * inverse;
  const double ratio_i = cos_i / root_i;
  const double ratio_o = cos_o / root_o;
  const double root_by_alpha =
      cos_i * (1.0 - cos_o * cos_o) / root_o + cos_o * (1.0 - cos_i * cos_i) / root_i;
  return {value,
          value * (by_sum - shadowing * (root_o + cos_o * q * ratio_i)),
          value * (by_sum - shadowing * (root_i + cos_i * q * ratio_o)),
          value * (-by_cos_h2 * 2.0 * cos_h2 * inverse),
          value * (2.0 / alpha - 4.0 * alpha * cos_h2 * inverse_base -
                   shadowing * alpha * root_by_alpha)};
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

/// Refraction through a rough interface, from the cosines of the two directions on either side
/// (cos_i < 0 < cos_o), as radiance along wo per irradiance along wi:
///   |wi.h| |wo.h| / (|cos_i| cos_o) (1 - F) D G2 / |wo + e wi|^2,  h along wo + e wi,
/// with `e` the index on the side of wi over the one on the side of wo, and G2 = 1 / (1 + Lambda_i
/// + Lambda_o) as for reflection. Zero where the microfacet would be seen from behind.
/// Source: [Walter2007, eq. 21]. At the microfacet the refracted cosine is |wi.h|, so that
/// Fresnel's equations need no root.
template <class T>
T MicrofacetTransmission(
    const T& cos_i, const T& cos_o, const T& dot_io, const T& alpha, const T& e) {
  using std::sqrt;
  const T sum = cos_o + e * cos_i;
  const T side = T(ScalarPart(sum) > 0.0 ? 1.0 : -1.0);
  // |wo + e wi| times the cosines of the two directions to the microfacet.
  const T facing_o = side * (T(1.0) + e * dot_io);
  const T facing_i = -side * (e + dot_io);
  if (ScalarPart(facing_o) <= 0.0 || ScalarPart(facing_i) <= 0.0) return T(0.0);
  const T length2 = (T(1.0) - e) * (T(1.0) - e) + T(2.0) * e * (T(1.0) + dot_io);
  const T alpha2 = alpha * alpha;
  const T cos_h2 = sum * sum / length2;
  const T base = cos_h2 * (alpha2 - T(1.0)) + T(1.0);
  const T distribution = alpha2 / (T(std::numbers::pi) * base * base);
  const T root_i = sqrt(alpha2 + (T(1.0) - alpha2) * cos_i * cos_i);
  const T root_o = sqrt(alpha2 + (T(1.0) - alpha2) * cos_o * cos_o);
  const T shadowing = T(2.0) / (cos_o * root_i - cos_i * root_o);
  const T s = facing_o + e * facing_i;
  const T p = e * facing_o + facing_i;
  const T both = facing_o * facing_i;
  const T transmitted = T(2.0) * e * both * (T(1.0) / (s * s) + T(1.0) / (p * p));
  return distribution * shadowing * transmitted * both / (length2 * length2);
}

}  // namespace pathfit::renderer
