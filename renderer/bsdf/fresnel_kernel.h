#pragma once

#include <cmath>

#include "renderer/math/dual.h"

namespace pathfit::renderer {

/// The value behind a number type, for branches: double, Dual, or a type with a member `a`
/// (ceres::Jet).
inline double ScalarPart(double x) { return x; }
template <int N>
double ScalarPart(const Dual<N>& x) {
  return x.v;
}
template <class T>
double ScalarPart(const T& x) {
  return x.a;
}

/// Squared cosine beyond the interface (times the squared index) below which all light is
/// reflected: just above zero, so that derivatives stay finite at the critical angle.
inline constexpr double kMinRefracted2 = 1e-12;

/// True where an interface of relative index `e` (beyond over here) reflects all light that meets
/// it at cosine `c`.
inline bool IsTotalReflection(double c, double e) { return e * e - 1.0 + c * c <= kMinRefracted2; }

/// Unpolarised reflectance of a smooth interface at cosine `c` >= 0 on this side; `e` is the index
/// beyond over the index here. One, without derivatives, in total reflection. Source: Fresnel's
/// equations.
template <class T>
T FresnelDielectric(const T& c, const T& e) {
  using std::sqrt;
  const T e2 = e * e;
  const T refracted2 = e2 - T(1.0) + c * c;
  if (ScalarPart(refracted2) <= kMinRefracted2) return T(1.0);
  const T g = sqrt(refracted2);
  const T s = (c - g) / (c + g);
  const T p = (e2 * c - g) / (e2 * c + g);
  return T(0.5) * (s * s + p * p);
}

/// Unpolarised reflectance of a metal of index eta + i k at cosine `c`; eta = k = 0 gives one.
/// With z^2 = (eta + i k)^2 - sin^2 and z = a + i b: a^2 + b^2 = |z^2|, R_s = |(c - z) / (c + z)|^2
/// and R_p = R_s |(z c - sin^2) / (z c + sin^2)|^2. Source: Fresnel's equations.
template <class T>
T FresnelConductor(const T& c, const T& eta, const T& k) {
  using std::sqrt;
  constexpr double kNoField2 = 1e-60;
  const T c2 = c * c;
  const T s2 = T(1.0) - c2;
  const T real = eta * eta - k * k - s2;
  const T imaginary = eta * k;
  const T modulus2 = real * real + T(4.0) * imaginary * imaginary;
  if (ScalarPart(modulus2) <= kNoField2) {
    return T(1.0);  // critical angle, or no index at all
  }
  const T modulus = sqrt(modulus2);
  // Of the two ways to the real part of the root, the one without cancellation.
  const T a = ScalarPart(real) > 0.0 ? sqrt(T(0.5) * (modulus + real))
                                     : imaginary / sqrt(T(0.5) * (modulus - real));
  const T cross = T(2.0) * a * c;
  const T s = (modulus + c2 - cross) / (modulus + c2 + cross);
  const T even = c2 * modulus + s2 * s2;
  return T(0.5) * s * (T(1.0) + (even - cross * s2) / (even + cross * s2));
}

}  // namespace pathfit::renderer
