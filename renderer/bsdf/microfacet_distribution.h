#pragma once

#include <cmath>
#include <numbers>

#include "renderer/bsdf/bsdf.h"
#include "renderer/bsdf/fresnel_kernel.h"

namespace pathfit::renderer {

// Distributions of microfacet normals h of roughness alpha. What the kernels need of each:
//   Density, D(h) per solid angle of h, from the squared cosine of h;
//   ProjectedArea of all microfacets, front and back, along a direction of cosine c > 0 to the
//     normal, per area of surface: c (1 + 2 Lambda(c)) by Smith's Lambda. With A = ProjectedArea,
//     G1 = 2 c / (c + A) and G2 = 2 c_i c_o / (c_i A_o + c_o A_i), height-correlated.
// The same with partials by hand: those of log D (finite where D underflows), and those of A.
// Source: [Walter2007], [Heitz2014, eqs. 71, 99].

struct DensityPartials {
  double value, log_by_cos_h2, log_by_alpha;
};
struct AreaPartials {
  double value, by_cos, by_alpha;
};

struct Ggx {
  template <class T>
  static T Density(const T& cos_h2, const T& alpha) {
    const T alpha2 = alpha * alpha;
    const T base = cos_h2 * (alpha2 - T(1.0)) + T(1.0);
    return alpha2 / (T(std::numbers::pi) * base * base);
  }
  template <class T>
  static T ProjectedArea(const T& c, const T& alpha) {
    using std::sqrt;
    const T alpha2 = alpha * alpha;
    return sqrt(alpha2 + (T(1.0) - alpha2) * c * c);
  }
  static DensityPartials EvalDensityPartials(double cos_h2, double alpha) {
    const double alpha2 = alpha * alpha;
    const double q = 1.0 - alpha2;
    const double inverse_base = 1.0 / (1.0 - q * cos_h2);
    return {alpha2 * std::numbers::inv_pi * inverse_base * inverse_base,
            2.0 * q * inverse_base,
            2.0 / alpha - 4.0 * alpha * cos_h2 * inverse_base};
  }
  static AreaPartials EvalAreaPartials(double c, double alpha) {
    const double area = ProjectedArea(c, alpha);
    return {area, (1.0 - alpha * alpha) * c / area, alpha * (1.0 - c * c) / area};
  }
};

struct Beckmann {
  template <class T>
  static T Density(const T& cos_h2, const T& alpha) {
    using std::exp;
    constexpr double kUnderflow = 700.0;
    const T alpha2 = alpha * alpha;
    if (ScalarPart(cos_h2) * (1.0 + kUnderflow * ScalarPart(alpha2)) < 1.0) return T(0.0);
    return exp((T(1.0) - T(1.0) / cos_h2) / alpha2) /
           (T(std::numbers::pi) * alpha2 * cos_h2 * cos_h2);
  }
  /// c erf(a) + alpha s exp(-a^2) / sqrt(pi), with s the sine and a = c / (alpha s).
  template <class T>
  static T ProjectedArea(const T& c, const T& alpha) {
    using std::erf;
    using std::exp;
    using std::sqrt;
    if (IsUnshadowed(ScalarPart(c), ScalarPart(alpha))) return c;
    const T slope = alpha * sqrt(T(1.0) - c * c);
    const T a = c / slope;
    return c * erf(a) + slope * exp(-(a * a)) * T(std::numbers::inv_sqrtpi);
  }
  static DensityPartials EvalDensityPartials(double cos_h2, double alpha) {
    const double inverse = 1.0 / cos_h2;
    const double inverse_alpha2 = 1.0 / (alpha * alpha);
    const double tan2 = inverse - 1.0;
    return {Density(cos_h2, alpha),
            inverse * (inverse * inverse_alpha2 - 2.0),
            2.0 / alpha * (tan2 * inverse_alpha2 - 1.0)};
  }
  static AreaPartials EvalAreaPartials(double c, double alpha) {
    if (IsUnshadowed(c, alpha)) return {c, 1.0, 0.0};
    const double s = std::sqrt(1.0 - c * c);
    const double a = c / (alpha * s);
    const double erf = std::erf(a);
    const double tail = std::exp(-a * a) * std::numbers::inv_sqrtpi;
    return {c * erf + alpha * s * tail, erf - alpha * c / s * tail, s * tail};
  }

 private:
  /// a > 6: what is shadowed is below rounding.
  static bool IsUnshadowed(double c, double alpha) {
    return c * c > 36.0 * alpha * alpha * (1.0 - c * c);
  }
};

/// `f` of the distribution of that name.
template <class F>
auto WithDistribution(MicrofacetDistribution distribution, F f) {
  return distribution == MicrofacetDistribution::kBeckmann ? f(Beckmann{}) : f(Ggx{});
}

}  // namespace pathfit::renderer
