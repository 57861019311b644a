#pragma once

#include <array>
#include <cstddef>

#include "tests/renderer/theory/evolving_surface.h"
#include "tests/support/quadrature.h"

// Integrals over evolving surfaces and their curves, by quadrature in local coordinates.
namespace pathfit::tests {

/// A rectangle of local coordinates.
struct LocalBox {
  double xi1_min = 0.0, xi1_max = 1.0, xi2_min = 0.0, xi2_max = 1.0;
};

/// int integrand(LocalPoint) dA at this pi.
template <class Surface, class F>
double SurfaceIntegral(const Surface& surface, const LocalBox& box, double pi, const F& integrand) {
  return Integrate2D(
      [&](double xi1, double xi2) {
        const renderer::LocalPoint<double> at{xi1, xi2, pi};
        return integrand(at) * AreaElement(surface, at);
      },
      box.xi1_min,
      box.xi1_max,
      box.xi2_min,
      box.xi2_max,
      4,
      4);
}

/// int integrand(s) dl over s in [s0, s1] at this pi.
template <class Surface, class Curve, class F>
double CurveIntegral(const Surface& surface,
                     const Curve& curve,
                     double pi,
                     const F& integrand,
                     double s0 = 0.0,
                     double s1 = 1.0) {
  return Integrate(
      [&](double s) { return integrand(s) * Norm(renderer::CurveTangent(surface, curve, s, pi)); },
      s0,
      s1);
}

/// One side of a box, counter-clockwise: 0 bottom (xi2 min), 1 right, 2 top, 3 left.
struct BoxSide {
  LocalBox box;
  int side = 0;
  template <class T>
  std::array<T, 2> operator()(const T& s, const T& /*pi*/) const {
    const T along1 = box.xi1_min + (box.xi1_max - box.xi1_min) * s;
    const T along2 = box.xi2_min + (box.xi2_max - box.xi2_min) * s;
    if (side == 0) return {along1, T(box.xi2_min)};
    if (side == 1) return {T(box.xi1_max), along2};
    if (side == 2) return {box.xi1_min + box.xi1_max - along1, T(box.xi2_max)};
    return {T(box.xi1_min), box.xi2_min + box.xi2_max - along2};
  }
};

/// int phi V_c dl over a border (or, with a curve of unit jump, over a discontinuity).
template <class Surface, class Field, class Curve>
double FluxThrough(const Surface& surface,
                   const Field& field,
                   const Curve& curve,
                   double pi,
                   double s0 = 0.0,
                   double s1 = 1.0) {
  return CurveIntegral(
      surface,
      curve,
      pi,
      [&](double s) {
        const auto xi = curve(s, pi);
        const renderer::LocalPoint<double> at{xi[0], xi[1], pi};
        return field(surface(at), pi) * renderer::CurveNormalVelocity(surface, curve, s, pi);
      },
      s0,
      s1);
}

/// FluxThrough the four sides of a box fixed in local coordinates: the border term of (T).
template <class Surface, class Field>
double BorderTerm(const Surface& surface, const Field& field, const LocalBox& box, double pi) {
  double sum = 0.0;
  for (int side = 0; side < 4; ++side) sum += FluxThrough(surface, field, BoxSide{box, side}, pi);
  return sum;
}

}  // namespace pathfit::tests
