#pragma once

#include <cmath>

#include "renderer/math/vector.h"

// Path_space 1.6 and 1.7 for one boundary segment: from x_D (detector side) to x_S (source side),
// grazing an edge at x_B between them.
namespace pathfit::renderer {

template <class T>
struct GrazingSegment {
  Vector3<T> x_d, x_b, x_s;
  Vector3<T> edge;           ///< unit tangent tau of the edge
  Vector3<T> into_occluder;  ///< from the edge to the third corner of a face beside it
};

/// Velocities of the labelled points: x_D and x_S by their labels, x_B by the edge's two corners.
template <class T>
struct GrazingMotion {
  Vector3<T> v_d, v_b, v_s;
};

/// w, unit, from D to S.
template <class T>
Vector3<T> Direction(const GrazingSegment<T>& s) {
  return Normalized(s.x_s - s.x_d);
}

/// lambda = |x_B - x_D| / |x_S - x_D|.
template <class T>
T Lambda(const GrazingSegment<T>& s) {
  return Norm(s.x_b - s.x_d) / Norm(s.x_s - s.x_d);
}

/// sin(phi) = |tau x w|: the whole weight of (K).
template <class T>
T SinPhi(const GrazingSegment<T>& s) {
  return Norm(Cross(s.edge, Direction(s)));
}

/// n_B = +-(tau x w) / |tau x w|, pointing into the occluder.
template <class T>
Vector3<T> OccluderNormal(const GrazingSegment<T>& s) {
  const Vector3<T> e = Normalized(Cross(s.edge, Direction(s)));
  return Dot(e, s.into_occluder) < T(0.0) ? -e : e;
}

/// g: signed distance by which the line x_D x_S misses the edge's line, > 0 on the occluded side.
template <class T>
T MissDistance(const GrazingSegment<T>& s) {
  return Dot(OccluderNormal(s), s.x_d - s.x_b);
}

/// (V): V_rel = n_B . (v_B - (1 - lambda) v_D - lambda v_S) = -g'. More becomes visible where it is
/// positive.
template <class T>
T RelativeVelocity(const GrazingSegment<T>& s, const GrazingMotion<T>& m) {
  const T lambda = Lambda(s);
  return Dot(OccluderNormal(s), m.v_b - m.v_d * (1.0 - lambda) - m.v_s * lambda);
}

/// The shadow's border on the surface of x_S: tangent q and in-surface normal m.
template <class T>
struct ShadowCurve {
  Vector3<T> q, m;
};
template <class T>
ShadowCurve<T> ShadowCurveOn(const GrazingSegment<T>& s, const Vector3<T>& n_s) {
  const Vector3<T> q = Normalized(Cross(OccluderNormal(s), n_s));
  return {q, Cross(n_s, q)};
}

/// Step 1: delta(g) dA(x_S) = this dl(x_S), at fixed x_D. Also V_DeltaB / V_rel.
template <class T>
T CurveDensity(const GrazingSegment<T>& s, const Vector3<T>& n_s) {
  using std::abs;
  return 1.0 / (Lambda(s) * abs(Dot(OccluderNormal(s), ShadowCurveOn(s, n_s).m)));
}

/// V_DeltaB: velocity of the shadow's border over the material of x_S, towards the occluded side.
template <class T>
T ShadowCurveVelocity(const GrazingSegment<T>& s,
                      const GrazingMotion<T>& m,
                      const Vector3<T>& n_s) {
  return RelativeVelocity(s, m) * CurveDensity(s, n_s);
}

/// Step 2: dl(x_S) / dl(x_B), the edge's shadow from the fixed x_D.
template <class T>
T ShadowLength(const GrazingSegment<T>& s, const Vector3<T>& n_s) {
  return SinPhi(s) / (Lambda(s) * Norm(Cross(Direction(s), ShadowCurveOn(s, n_s).q)));
}

/// Step 3: dA(x_D) / dsigma(w) at fixed x_B.
template <class T>
T DetectorArea(const GrazingSegment<T>& s, const Vector3<T>& n_d) {
  using std::abs;
  return SquaredNorm(s.x_b - s.x_d) / abs(Dot(n_d, Direction(s)));
}

/// (B) without Phi_D and Phi_S: contribution per edge length and solid angle at x_B.
template <class T>
T BoundaryWeight(const GrazingSegment<T>& s, const GrazingMotion<T>& m) {
  return SinPhi(s) * RelativeVelocity(s, m);
}

/// (B0): the same for one fixed receiver x_D with normal n_d, per edge length only.
template <class T>
T PointReceiverWeight(const GrazingSegment<T>& s,
                      const GrazingMotion<T>& m,
                      const Vector3<T>& n_d) {
  return BoundaryWeight(s, m) / DetectorArea(s, n_d);
}

/// u': velocity over the material of x_S of the point where the moving line x_D x_B meets the
/// moving triangle of x_S: in that triangle's plane.
template <class T>
Vector3<T> RayFootVelocity(const GrazingSegment<T>& s,
                           const GrazingMotion<T>& m,
                           const Vector3<T>& n_s) {
  const Vector3<T> w = Direction(s);
  const Vector3<T> beside = m.v_d + (m.v_b - m.v_d) / Lambda(s) - m.v_s;
  return beside - w * (Dot(n_s, beside) / Dot(n_s, w));
}

/// Formula A: the released codes' form of BoundaryWeight. Singular when w is parallel to q; here to
/// show that the two agree.
template <class T>
T FormulaA(const GrazingSegment<T>& s, const GrazingMotion<T>& motion, const Vector3<T>& n_s) {
  using std::abs;
  const Vector3<T> w = Direction(s);
  const Vector3<T> e = Cross(s.edge, w);
  const Vector3<T> q = Normalized(Cross(e, n_s));
  const Vector3<T> m = Normalized(Cross(n_s, q));
  const T base = Lambda(s) * Norm(e) / Norm(Cross(w, q)) * abs(Dot(n_s, w));
  const bool same_sign = (Dot(e, s.into_occluder) > T(0.0)) == (Dot(e, m) > T(0.0));
  const T value = base * Dot(m, RayFootVelocity(s, motion, n_s));
  return same_sign ? value : -value;
}

}  // namespace pathfit::renderer
