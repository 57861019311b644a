#pragma once

#include <array>
#include <cstddef>

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// A triangle whose corners move with constant velocities: corner i is at p[i] + pi v[i].  [S
/// 34-37] The reference configuration is pi = 0; all derivatives below are taken there.
template <class T>
struct TriangleMotion {
  std::array<Vector3<T>, 3> p;
  std::array<Vector3<T>, 3> v;
};

/// The point with barycentrics (1 - s - t, s, t) at pi.  [S 37]
template <class T>
Vector3<T> PointOf(const TriangleMotion<T>& m, const T& s, const T& t, const T& pi) {
  const auto corner = [&](std::size_t i) { return m.p[i] + m.v[i] * pi; };
  return corner(0) * (1.0 - s - t) + corner(1) * s + corner(2) * t;
}

/// x'(s, t), the same at every pi.
template <class T>
Vector3<T> VelocityOf(const TriangleMotion<T>& m, const T& s, const T& t) {
  return m.v[0] * (1.0 - s - t) + m.v[1] * s + m.v[2] * t;
}

/// Coefficients of N(pi) = N0 + pi N1 + pi^2 N2 / 2: twice the area, along the normal.  [S 40]
template <class T>
struct NormalSeries {
  Vector3<T> n0, n1, n2;
};
template <class T>
NormalSeries<T> NormalSeriesOf(const TriangleMotion<T>& m) {
  const Vector3<T> d = m.p[1] - m.p[0];
  const Vector3<T> e = m.p[2] - m.p[0];
  const Vector3<T> dd = m.v[1] - m.v[0];
  const Vector3<T> de = m.v[2] - m.v[0];
  return {Cross(d, e), Cross(d, de) + Cross(dd, e), Cross(dd, de) * T(2.0)};
}

/// N(pi).
template <class T>
Vector3<T> AreaVector(const TriangleMotion<T>& m, const T& pi) {
  const NormalSeries<T> n = NormalSeriesOf(m);
  return n.n0 + n.n1 * pi + n.n2 * (pi * pi * 0.5);
}

/// J(pi) = |N(pi)| / |N(0)|, constant over the triangle.  [S 40]
template <class T>
T AreaRatio(const TriangleMotion<T>& m, const T& pi) {
  return Norm(AreaVector(m, pi)) / Norm(NormalSeriesOf(m).n0);
}

/// J'(0) = N0 . N1 / |N0|^2. BarycentricGradients (geometry/triangle_kernel.h) are its partials by
/// the three corners.
template <class T>
T AreaRatioDerivative(const TriangleMotion<T>& m) {
  const NormalSeries<T> n = NormalSeriesOf(m);
  return Dot(n.n0, n.n1) / SquaredNorm(n.n0);
}

/// J''(0).
template <class T>
T AreaRatioSecondDerivative(const TriangleMotion<T>& m) {
  const NormalSeries<T> n = NormalSeriesOf(m);
  const T squared = SquaredNorm(n.n0);
  const T first = Dot(n.n0, n.n1) / squared;
  return (SquaredNorm(n.n1) + Dot(n.n0, n.n2)) / squared - first * first;
}

/// n'(0) = (I - n n^T) N1 / |N0|. NormalAdjoint (geometry/triangle_kernel.h) is its transpose.
template <class T>
Vector3<T> UnitNormalDerivative(const TriangleMotion<T>& m) {
  const NormalSeries<T> series = NormalSeriesOf(m);
  const T length = Norm(series.n0);
  const Vector3<T> n = series.n0 / length;
  return (series.n1 - n * Dot(n, series.n1)) / length;
}

/// div_M v = trace((T^T T)^-1 T^T W), T = [d e], W = [d' e']: a second way to J'(0).
template <class T>
T VelocityDivergence(const TriangleMotion<T>& m) {
  const Vector3<T> d = m.p[1] - m.p[0];
  const Vector3<T> e = m.p[2] - m.p[0];
  const Vector3<T> dd = m.v[1] - m.v[0];
  const Vector3<T> de = m.v[2] - m.v[0];
  const T g11 = Dot(d, d);
  const T g12 = Dot(d, e);
  const T g22 = Dot(e, e);
  return (g22 * Dot(d, dd) - g12 * (Dot(e, dd) + Dot(d, de)) + g11 * Dot(e, de)) /
         (g11 * g22 - g12 * g12);
}

}  // namespace pathfit::renderer
