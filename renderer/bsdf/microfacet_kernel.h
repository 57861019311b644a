#pragma once

#include <cmath>

#include "renderer/bsdf/fresnel_kernel.h"
#include "renderer/bsdf/microfacet_distribution.h"

namespace pathfit::renderer {

/// Microfacet distribution times height-correlated Smith visibility, D(h) V(i, o) with V = G2 / (4
/// cos_i cos_o), from the three cosines of a reflection. Template on the number type: double, Dual
/// or ceres::Jet. Source: glTF 2.0 specification, appendix B; [Heitz2014, eq. 99].
template <class Distribution = Ggx, class T>
T MicrofacetReflection(const T& cos_i, const T& cos_o, const T& dot_io, const T& alpha) {
  const T sum = cos_i + cos_o;
  // cos_h^2 = (cos_i + cos_o)^2 / |wi + wo|^2.
  const T cos_h2 = sum * sum / (T(2.0) + T(2.0) * dot_io);
  const T area_i = Distribution::ProjectedArea(cos_i, alpha);
  const T area_o = Distribution::ProjectedArea(cos_o, alpha);
  return Distribution::Density(cos_h2, alpha) * T(0.5) / (cos_i * area_o + cos_o * area_i);
}

/// Value and partials of MicrofacetReflection, by hand: this one is evaluated at every path vertex.
struct MicrofacetPartials {
  double value, d_cos_i, d_cos_o, d_dot_io, d_alpha;
};
template <class Distribution = Ggx>
MicrofacetPartials MicrofacetReflectionPartials(double cos_i,
                                                double cos_o,
                                                double dot_io,
                                                double alpha) {
  const double sum = cos_i + cos_o;
  const double inverse = 0.5 / (1.0 + dot_io);
  const double cos_h2 = sum * sum * inverse;
  const DensityPartials density = Distribution::EvalDensityPartials(cos_h2, alpha);
  const AreaPartials area_i = Distribution::EvalAreaPartials(cos_i, alpha);
  const AreaPartials area_o = Distribution::EvalAreaPartials(cos_o, alpha);
  const double shadowing = 1.0 / (cos_i * area_o.value + cos_o * area_i.value);
  const double value = 0.5 * density.value * shadowing;
  // d log of the product: d log D - d log of the shadowing's denominator.
  const double by_sum = density.log_by_cos_h2 * 2.0 * sum * inverse;
  return {value,
          value * (by_sum - shadowing * (area_o.value + cos_o * area_i.by_cos)),
          value * (by_sum - shadowing * (area_i.value + cos_i * area_o.by_cos)),
          value * (-density.log_by_cos_h2 * 2.0 * cos_h2 * inverse),
          value * (density.log_by_alpha -
                   shadowing * (cos_i * area_o.by_alpha + cos_o * area_i.by_alpha))};
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
template <class Distribution = Ggx, class T>
T MicrofacetTransmission(
    const T& cos_i, const T& cos_o, const T& dot_io, const T& alpha, const T& e) {
  const T sum = cos_o + e * cos_i;
  const T side = T(ScalarPart(sum) > 0.0 ? 1.0 : -1.0);
  // |wo + e wi| times the cosines of the two directions to the microfacet.
  const T facing_o = side * (T(1.0) + e * dot_io);
  const T facing_i = -side * (e + dot_io);
  if (ScalarPart(facing_o) <= 0.0 || ScalarPart(facing_i) <= 0.0) return T(0.0);
  const T length2 = (T(1.0) - e) * (T(1.0) - e) + T(2.0) * e * (T(1.0) + dot_io);
  const T area_i = Distribution::ProjectedArea(-cos_i, alpha);
  const T area_o = Distribution::ProjectedArea(cos_o, alpha);
  const T distribution = Distribution::Density(sum * sum / length2, alpha);
  const T shadowing = T(2.0) / (cos_o * area_i - cos_i * area_o);
  const T s = facing_o + e * facing_i;
  const T p = e * facing_o + facing_i;
  const T both = facing_o * facing_i;
  const T transmitted = T(2.0) * e * both * (T(1.0) / (s * s) + T(1.0) / (p * p));
  return distribution * shadowing * transmitted * both / (length2 * length2);
}

}  // namespace pathfit::renderer
