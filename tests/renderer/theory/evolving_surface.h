#pragma once

#include <array>

#include "renderer/math/vector.h"
#include "tests/renderer/theory/directional_dual.h"

// The vocabulary of path_space 1.2 for a parameterised evolving surface. Four kinds of callable,
// all templates on the number type T (double, DirectionalDual, ceres::Jet):
//   surface(LocalPoint<T>)     -> Vector3<T>        position x^(xi, pi), world
//   field(Vector3<T> x, T pi)  -> T                 a function of place and parameter
//   vectors(LocalPoint<T>)     -> Vector3<T>        a vector at each surface point
//   curve(T s, T pi)           -> array<T, 2>       local coordinates of a curve on the surface
// A field given on the surface only is continued into space by its formula; no result depends on
// how.
namespace pathfit::renderer {

/// Local coordinates xi of a surface point and the parameter pi.
template <class T>
struct LocalPoint {
  T xi1{}, xi2{}, pi{};
};

enum class LocalVariable { kXi1, kXi2, kPi };

template <class T>
LocalPoint<DirectionalDual<T>> Differentiating(const LocalPoint<T>& at, LocalVariable variable) {
  const auto seeded = [&](const T& value, LocalVariable own) {
    return DirectionalDual<T>(value, T(own == variable ? 1.0 : 0.0));
  };
  return {seeded(at.xi1, LocalVariable::kXi1),
          seeded(at.xi2, LocalVariable::kXi2),
          seeded(at.pi, LocalVariable::kPi)};
}

template <class T>
T DerivativePart(const DirectionalDual<T>& a) {
  return a.d;
}
template <class T>
Vector3<T> DerivativePart(const Vector3<DirectionalDual<T>>& a) {
  return {a.x.d, a.y.d, a.z.d};
}

/// d f / d variable of a function of LocalPoint, the other two held.
template <class F, class T>
auto PartialOf(const F& f, const LocalPoint<T>& at, LocalVariable variable) {
  return DerivativePart(f(Differentiating(at, variable)));
}

/// x = chi(p, pi): where the material point with these coordinates is.  [S 3]
template <class Surface, class T>
Vector3<T> MaterialPoint(const Surface& surface, const LocalPoint<T>& at) {
  return surface(at);
}

/// v = d/dpi x^(xi, pi): depends on the parameterisation.  [S 7, 9]
template <class Surface, class T>
Vector3<T> LocalVelocity(const Surface& surface, const LocalPoint<T>& at) {
  return PartialOf(surface, at, LocalVariable::kPi);
}

/// d x^ / d xi1 and d x^ / d xi2.
template <class Surface, class T>
std::array<Vector3<T>, 2> SurfaceTangents(const Surface& surface, const LocalPoint<T>& at) {
  return {PartialOf(surface, at, LocalVariable::kXi1), PartialOf(surface, at, LocalVariable::kXi2)};
}

/// n, on the side from which xi1 turns to xi2 counter-clockwise.
template <class Surface, class T>
Vector3<T> UnitNormal(const Surface& surface, const LocalPoint<T>& at) {
  const auto [t1, t2] = SurfaceTangents(surface, at);
  return Normalized(Cross(t1, t2));
}

/// dA / (dxi1 dxi2).
template <class Surface, class T>
T AreaElement(const Surface& surface, const LocalPoint<T>& at) {
  const auto [t1, t2] = SurfaceTangents(surface, at);
  return Norm(Cross(t1, t2));
}

/// V = v . n: the same for every parameterisation.  [S 10]
template <class Surface, class T>
T ScalarNormalVelocity(const Surface& surface, const LocalPoint<T>& at) {
  return Dot(LocalVelocity(surface, at), UnitNormal(surface, at));
}

/// v_tan = v - V n.  [S 11, 12]
template <class Surface, class T>
Vector3<T> TangentialVelocity(const Surface& surface, const LocalPoint<T>& at) {
  return LocalVelocity(surface, at) - UnitNormal(surface, at) * ScalarNormalVelocity(surface, at);
}

/// The tangents' dual basis: t^a . t_b = delta_ab, both in the tangent plane.
template <class Surface, class T>
std::array<Vector3<T>, 2> DualTangents(const Surface& surface, const LocalPoint<T>& at) {
  const auto [t1, t2] = SurfaceTangents(surface, at);
  const T g11 = Dot(t1, t1);
  const T g12 = Dot(t1, t2);
  const T g22 = Dot(t2, t2);
  const T determinant = g11 * g22 - g12 * g12;
  return {(t1 * g22 - t2 * g12) / determinant, (t2 * g11 - t1 * g12) / determinant};
}

/// phi(x^(xi, pi), pi) as a function of LocalPoint.
template <class Surface, class Field>
auto FieldOnSurface(const Surface& surface, const Field& field) {
  return [surface, field](const auto& at) { return field(surface(at), at.pi); };
}

/// phidot: derivative of the field that follows the point of fixed xi.  [S 14, 16]
template <class Surface, class Field, class T>
T SceneDerivative(const Surface& surface, const Field& field, const LocalPoint<T>& at) {
  return PartialOf(FieldOnSurface(surface, field), at, LocalVariable::kPi);
}

/// grad_M phi: tangential.
template <class Surface, class Field, class T>
Vector3<T> SurfaceGradient(const Surface& surface, const Field& field, const LocalPoint<T>& at) {
  const auto on_surface = FieldOnSurface(surface, field);
  const auto [d1, d2] = DualTangents(surface, at);
  return d1 * PartialOf(on_surface, at, LocalVariable::kXi1) +
         d2 * PartialOf(on_surface, at, LocalVariable::kXi2);
}

/// boxphi = phidot - v_tan . grad_M phi: the same for every parameterisation.  [S 15, 17]
template <class Surface, class Field, class T>
T NormalSceneDerivative(const Surface& surface, const Field& field, const LocalPoint<T>& at) {
  return SceneDerivative(surface, field, at) -
         Dot(TangentialVelocity(surface, at), SurfaceGradient(surface, field, at));
}

/// div_M of a vector at each surface point (not only tangential ones).
template <class Surface, class Vectors, class T>
T SurfaceDivergence(const Surface& surface, const Vectors& vectors, const LocalPoint<T>& at) {
  const auto [d1, d2] = DualTangents(surface, at);
  return Dot(d1, PartialOf(vectors, at, LocalVariable::kXi1)) +
         Dot(d2, PartialOf(vectors, at, LocalVariable::kXi2));
}

/// kappa = -div_M n: -2/r for a sphere with outward normal. Unit 1/length.  [S 32]
template <class Surface, class T>
T TotalCurvature(const Surface& surface, const LocalPoint<T>& at) {
  return -SurfaceDivergence(
      surface, [&](const auto& here) { return UnitNormal(surface, here); }, at);
}

/// div_M v = J'/J.  [path_space 1.2, proof of (T)]
template <class Surface, class T>
T VelocityDivergence(const Surface& surface, const LocalPoint<T>& at) {
  return SurfaceDivergence(
      surface, [&](const auto& here) { return LocalVelocity(surface, here); }, at);
}

/// B: the surface that stays where `surface` is at the reference parameter, with the same labels
/// xi.
template <class Surface>
auto ReferenceConfiguration(const Surface& surface, double reference_pi) {
  return [surface, reference_pi](auto at) {
    at.pi = reference_pi;
    return surface(at);
  };
}

/// J = dA(x) / dA(p), p the same label in the reference configuration.  [S 33]
template <class Surface, class T>
T AreaRatio(const Surface& surface, double reference_pi, const LocalPoint<T>& at) {
  return AreaElement(surface, at) / AreaElement(ReferenceConfiguration(surface, reference_pi), at);
}

/// boxphi - phi kappa V: what (T) integrates over M.  [S 20, 31]
template <class Surface, class Field, class T>
T TransportIntegrand(const Surface& surface, const Field& field, const LocalPoint<T>& at) {
  return NormalSceneDerivative(surface, field, at) - FieldOnSurface(surface, field)(at) *
                                                         TotalCurvature(surface, at) *
                                                         ScalarNormalVelocity(surface, at);
}

/// d/dpi [ phi J ] at fixed label: what (M) integrates over B.
template <class Surface, class Field, class T>
T MaterialIntegrand(const Surface& surface,
                    const Field& field,
                    double reference_pi,
                    const LocalPoint<T>& at) {
  const auto product = [&](const auto& here) {
    return FieldOnSurface(surface, field)(here) * AreaRatio(surface, reference_pi, here);
  };
  return PartialOf(product, at, LocalVariable::kPi);
}

/// A curve on the surface as a function of LocalPoint {s, unused, pi}.
template <class Surface, class Curve>
auto CurveOnSurface(const Surface& surface, const Curve& curve) {
  return [surface, curve](auto at) {
    const auto xi = curve(at.xi1, at.pi);
    at.xi1 = xi[0];
    at.xi2 = xi[1];
    return surface(at);
  };
}

/// d x / d s along the curve; its norm is dl / ds.
template <class Surface, class Curve, class T>
Vector3<T> CurveTangent(const Surface& surface, const Curve& curve, const T& s, const T& pi) {
  return PartialOf(
      CurveOnSurface(surface, curve), LocalPoint<T>{s, T(0.0), pi}, LocalVariable::kXi1);
}

/// m = tau x n: in-surface unit normal of the curve, on its right; outward for a border that runs
/// counter-clockwise about n.
template <class Surface, class Curve, class T>
Vector3<T> CurveNormal(const Surface& surface, const Curve& curve, const T& s, const T& pi) {
  const auto xi = curve(s, pi);
  return Cross(Normalized(CurveTangent(surface, curve, s, pi)),
               UnitNormal(surface, LocalPoint<T>{xi[0], xi[1], pi}));
}

/// V_c: velocity of the curve along m. With the reference configuration as surface this is the
/// V_DeltaB of (M); it is zero there for a curve fixed to the material.
template <class Surface, class Curve, class T>
T CurveNormalVelocity(const Surface& surface, const Curve& curve, const T& s, const T& pi) {
  const Vector3<T> velocity =
      PartialOf(CurveOnSurface(surface, curve), LocalPoint<T>{s, T(0.0), pi}, LocalVariable::kPi);
  return Dot(velocity, CurveNormal(surface, curve, s, pi));
}

}  // namespace pathfit::renderer
