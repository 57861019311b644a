#pragma once

#include <array>

#include "renderer/math/vector.h"

namespace pathfit::renderer {

/// A triangle prepared for shading: corner, edges from it, unit geometric normal, twice the area
/// and one over that.
struct TriangleGeometry {
  Vec3 p0, e1, e2;
  Vec3 n;
  double double_area = 0.0;
  double inverse_double_area = 0.0;

  static TriangleGeometry Make(const Vec3& p0, const Vec3& p1, const Vec3& p2) {
    TriangleGeometry t{p0, p1 - p0, p2 - p0, {}, 0.0, 0.0};
    const Vec3 normal = Cross(t.e1, t.e2);
    t.double_area = Norm(normal);
    t.n = normal / t.double_area;
    t.inverse_double_area = 1.0 / t.double_area;
    return t;
  }
  [[nodiscard]] std::array<Vec3, 3> Corners() const { return {p0, p0 + e1, p0 + e2}; }
  [[nodiscard]] Vec3 Point(double b1, double b2) const { return p0 + e1 * b1 + e2 * b2; }
};

/// Distance and barycentrics of a line with the triangle's plane; barycentrics may lie outside the
/// triangle.
struct PlaneHit {
  double distance = 0.0;
  double b1 = 0.0, b2 = 0.0;
};
inline PlaneHit IntersectPlane(const TriangleGeometry& t,
                               const Vec3& origin,
                               const Vec3& direction) {
  const Vec3 to_corner = t.p0 - origin;
  const double distance = Dot(t.n, to_corner) / Dot(t.n, direction);
  const Vec3 in_plane = direction * distance - to_corner;  // from p0 to the point
  return {distance,
          Dot(t.n, Cross(in_plane, t.e2)) * t.inverse_double_area,
          Dot(t.n, Cross(t.e1, in_plane)) * t.inverse_double_area};
}

/// In-plane gradients of the barycentric weights of the three corners: d b_i / d x for a point
/// moving in the plane. The same vectors are the gradients of log(area) by the corners, J'(0) of
/// path_space 1.3.
inline std::array<Vec3, 3> BarycentricGradients(const TriangleGeometry& t) {
  const Vec3 g1 = Cross(t.e2, t.n) * t.inverse_double_area;
  const Vec3 g2 = Cross(t.n, t.e1) * t.inverse_double_area;
  return {-(g1 + g2), g1, g2};
}

/// Pulls an adjoint of the unit normal back to the three corners.  [path_space 1.3, n'(0)]
inline std::array<Vec3, 3> NormalAdjoint(const TriangleGeometry& t, const Vec3& adjoint_n) {
  const Vec3 m = (adjoint_n - t.n * Dot(t.n, adjoint_n)) / t.double_area;
  const Vec3 a1 = Cross(t.e2, m);
  const Vec3 a2 = Cross(m, t.e1);
  return {-(a1 + a2), a1, a2};
}

}  // namespace pathfit::renderer
